"""Assembling: one conformal mesh, a crack that opens but for its front, and sets that say what they are."""

import numpy as np
import pytest
from plain_opening import slow_opening
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cracks.sheets import one_crack
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.front import front_polylines
from craftmesh.mesh.front_frames import front_frames
from craftmesh.mesh.tet_connectivity import FACE_CORNERS, face_nodes, tet_volumes
from craftmesh.types import CRACK, Crack, Surface


def one_grain(centres):
    return np.ones(len(centres), int)


def two_grains(centres):
    return np.where(centres[:, 0] < 2, 3, 7)


def edge_notch(centres):
    return centres[:, 0] < 2


PENNY = plane_crack(2, 2, hexagon((3, 3), 2))
EDGE = plane_crack(2, 2, edge_notch)


def coordinates(mesh, faces):
    return {tuple(sorted(map(tuple, p))) for p in mesh.points[face_nodes(mesh.tets, faces)].tolist()}


@pytest.mark.parametrize("crack_at", [None, PENNY, EDGE])
@pytest.mark.parametrize("label_of", [one_grain, two_grains])
def test_opening_agrees_with_a_slow_reference(label_of, crack_at):
    surface, grains = structured_box((6, 6, 4), label_of, crack_at)
    closed, _ = assemble(*structured_box((6, 6, 4), label_of))
    mesh, report = assemble(surface, grains)
    crack = surface.points[surface.facets[surface.kind == CRACK]]
    ids = {tuple(p): i for i, p in enumerate(closed.points.tolist())}
    crack_faces = {frozenset(ids[tuple(p)] for p in face) for face in crack.tolist()}
    assert report["nodes"] == len(mesh.points) == slow_opening(closed.tets, crack_faces)
    assert report["nodes_opened_by_crack"] == len(mesh.points) - len(closed.points)
    assert (report["nodes_opened_by_crack"] > 0) == (crack_at is not None)
    assert report["nodes_unwelded"] == 0 and report["crack_facets_not_opened"] == 0
    assert set(np.unique(mesh.tets)) == set(range(len(mesh.points)))


def test_penny_crack_has_a_closed_front_and_coincident_lips():
    mesh, report = assemble(*structured_box((6, 6, 4), two_grains, PENNY))
    a, b = (mesh.face_sets[f"CRACK_LIP_{side}"] for side in "AB")
    assert coordinates(mesh, a) == coordinates(mesh, b) and len(a) == report["crack_facets"]
    assert report["crack_area"] == pytest.approx(len(a) / 2)
    centre = mesh.points[mesh.tets].mean(axis=1)
    assert (centre[a[:, 0], 2] > 2).all() and (centre[b[:, 0], 2] < 2).all()  # A is ahead of the normal +z
    front = mesh.node_sets["CRACK_FRONT"]
    lip_nodes = [set(mesh.node_sets[f"CRACK_LIP_{side}"].tolist()) for side in "AB"]
    assert lip_nodes[0] & lip_nodes[1] == set(front.tolist()) and len(set(front.tolist())) == len(front)
    assert report["fronts"] == 1 and "CRACK_FRONT_1" not in mesh.node_sets
    assert front_polylines(mesh.points, mesh.tets, mesh.face_sets)[0][1]
    lowest = min(map(tuple, mesh.points[front].tolist()))
    assert tuple(mesh.points[front[0]].tolist()) == lowest


def test_front_frames_point_out_of_the_crack():
    mesh, report = assemble(*structured_box((6, 6, 4), one_grain, PENNY))
    frames = front_frames(mesh)
    assert np.allclose(frames.normal, [0, 0, 1], atol=1e-12)
    assert (frames.closed == 1).all() and (frames.front == 1).all()
    outward = frames.points - [3, 3, 2]
    assert ((outward * frames.binormal).sum(axis=1) > 0).all()
    assert np.allclose(np.cross(frames.tangent, frames.normal), frames.binormal, atol=1e-15)
    steps = np.linalg.norm(np.diff(frames.points, axis=0, append=frames.points[:1]), axis=1)
    assert np.allclose(np.diff(frames.s), steps[:-1]) and frames.s[0] == 0
    assert report["front_length"] == pytest.approx(frames.s[-1] + steps[-1])
    assert list(frames.columns())[:3] == ["s", "points", "tangent"]


def test_edge_crack_opens_at_its_mouths_and_its_front_is_ordered():
    mesh, report = assemble(*structured_box((4, 4, 4), two_grains, EDGE))
    front = mesh.points[mesh.node_sets["CRACK_FRONT"]]
    assert front.tolist() == [[2, y, 2] for y in range(5)] or front.tolist() == [
        [2, y, 2] for y in range(4, -1, -1)
    ]
    assert not front_frames(mesh).closed.any()
    assert np.allclose(front_frames(mesh).binormal, [1, 0, 0])
    mouth = mesh.points[mesh.node_sets["XMIN"]]
    assert (mouth[:, 2] == 2).sum() == 2 * 5  # every mouth node is there on both lips
    assert report["nodes_opened_by_crack"] == 2 * 5


def both(centres):
    return (centres[:, 0] < 2) | (centres[:, 0] > 4)


def given_plate(low, high):
    """Return a given crack in the plane z = 1 from x = low to x = high, without a front."""
    corners = [[low, -1, 1], [high, -1, 1], [high, 4, 1], [low, 4, 1]]
    return Crack(np.array(corners, float), np.array([[0, 1, 2], [0, 2, 3]]), ())


LEFT, RIGHT = given_plate(-1, 2), given_plate(4, 7)


@pytest.mark.parametrize(
    ("crack", "least"),
    [
        (None, {"CRACK_1_LIP_A": 0.0, "CRACK_2_LIP_A": 4.0}),
        (given_plate(-1, 7), {"CRACK_LIP_A": 0.0}),
        (one_crack([LEFT, RIGHT]), {"CRACK_1_LIP_A": 0.0, "CRACK_2_LIP_A": 4.0}),
        (one_crack([RIGHT, LEFT]), {"CRACK_1_LIP_A": 4.0, "CRACK_2_LIP_A": 0.0}),
    ],
    ids=["none given", "one in two pieces", "two", "two the other way"],
)
def test_a_given_crack_has_plain_sets_in_however_many_pieces(crack, least):
    mesh, report = assemble(*structured_box((6, 3, 2), one_grain, plane_crack(2, 1, both)), crack)
    lips = {name: faces for name, faces in mesh.face_sets.items() if name.endswith("LIP_A")}
    assert {
        name: mesh.points[face_nodes(mesh.tets, faces)][..., 0].min() for name, faces in lips.items()
    } == (least)
    assert report["cracks"] == len(least) and report["fronts"] == 2


def test_given_cracks_that_have_grown_together_are_one():
    surface, grains = structured_box(
        (6, 3, 2), one_grain, plane_crack(2, 1, lambda centres: centres[:, 0] < 4)
    )
    mesh, report = assemble(surface, grains, one_crack([given_plate(1, 4), given_plate(-1, 2)]))
    assert report["cracks"] == 1 and "CRACK_LIP_A" in mesh.face_sets
    assert len(mesh.face_sets["CRACK_LIP_A"]) == report["crack_facets"]


def test_two_cracks_give_two_ordered_fronts():
    mesh, report = assemble(*structured_box((6, 3, 2), one_grain, plane_crack(2, 1, both)))
    assert report["fronts"] == 2
    parts = [mesh.node_sets[f"CRACK_FRONT_{k}"] for k in (1, 2)]
    assert (np.concatenate(parts) == mesh.node_sets["CRACK_FRONT"]).all()
    assert [set(mesh.points[p][:, 0]) for p in parts] == [{2.0}, {4.0}]


def test_box_planes_edges_and_corners_are_exact():
    origin, spacing = np.array([0.1, -2.0, 1e-3]), np.array([0.3, 1 / 3, 2.0])
    mesh, _ = assemble(*structured_box((3, 4, 2), one_grain, None, spacing, origin))
    ends = {"MIN": origin, "MAX": np.array([3, 4, 2]) * spacing + origin}
    names = [name for name in mesh.node_sets if name[0] in "XYZ"]
    assert len(names) == 6 + 12 + 8
    for name in names:
        expected = np.ones(len(mesh.points), bool)
        for plane in name.split("_"):
            axis = "XYZ".index(plane[0])
            expected &= mesh.points[:, axis] == ends[plane[1:]][axis]
        assert (np.flatnonzero(expected) == mesh.node_sets[name]).all(), name


def test_voids_and_exterior_are_named():
    def label_of(centres):
        x, y, z = centres.T
        labels = np.where(x < 3, 2, 5)
        labels[(np.abs(x - 2.5) < 1) & (np.abs(y - 2.5) < 1) & (np.abs(z - 2.5) < 1)] = -4
        labels[(x > 5) & (z > 4)] = 0
        return labels

    mesh, report = assemble(*structured_box((6, 5, 5), label_of))
    assert report["faces"]["VOID_4"] == 2 * 6  # a void of one cube
    exterior = mesh.points[face_nodes(mesh.tets, mesh.face_sets["EXTERIOR"])]
    assert len(exterior) == 2 * 5 + 2 * 5
    assert ((exterior[:, :, 0] == 5).all(1) | (exterior[:, :, 2] == 4).all(1)).all()
    total = sum(len(f) for f in mesh.face_sets.values())
    sorted_faces = np.sort(mesh.tets[:, FACE_CORNERS].reshape(-1, 3), 1)
    _, count = np.unique(sorted_faces, axis=0, return_counts=True)
    assert total == (count == 1).sum() and count.max() == 2


def test_bodies_that_touch_in_an_edge_or_a_point_come_apart():
    def checkerboard(centres):
        return np.where(centres.astype(int).sum(1) % 2, 1, 0)

    mesh, report = assemble(*structured_box((2, 2, 2), checkerboard))
    assert len(mesh.points) == 4 * 8 and report["nodes_opened_by_crack"] == 0
    assert report["nodes_unwelded"] == 4 * 8 - (27 - 4)  # four corners of the box have no material
    assert (tet_volumes(mesh.points, mesh.tets) > 0).all()


def test_a_facet_that_has_only_front_corners_is_reported():
    one_facet = plane_crack(2, 2, lambda c: (np.abs(c - [2 + 1 / 3, 2 + 2 / 3, 2]) < 1e-6).all(axis=1))
    _, report = assemble(*structured_box((4, 4, 4), one_grain, one_facet))
    assert report["crack_facets"] == report["crack_facets_not_opened"] == 1
    assert report["fronts"] == 0


def test_crack_along_a_grain_boundary_opens():
    along = plane_crack(0, 2, lambda c: c[:, 1] < 2)
    mesh, report = assemble(*structured_box((4, 4, 4), two_grains, along))
    assert set(mesh.grain[mesh.face_sets["CRACK_LIP_A"][:, 0]]) == {7}
    assert set(mesh.grain[mesh.face_sets["CRACK_LIP_B"][:, 0]]) == {3}
    assert report["nodes_opened_by_crack"] == 2 * 5


def test_order_of_the_grains_does_not_matter():
    surface, grains = structured_box((4, 4, 4), two_grains, EDGE)
    first, second = assemble(surface, grains)[0], assemble(surface, grains[::-1])[0]
    assert (first.points == second.points).all() and (first.tets == second.tets).all()


def test_what_does_not_fit_is_refused():
    surface, grains = structured_box((4, 4, 4), two_grains)
    with pytest.raises(CraftmeshError, match="no tetrahedra"):
        assemble(surface, [])
    with pytest.raises(CraftmeshError, match="grain 7: .* facets"):
        assemble(surface, grains[:1])
    other = structured_box((4, 4, 3), two_grains)[1]
    with pytest.raises(CraftmeshError, match="grain"):
        assemble(surface, other)
    twice = [
        np.concatenate([getattr(surface, n), getattr(surface, n)[:1]]) for n in ("facets", "sides", "kind")
    ]
    with pytest.raises(CraftmeshError, match="duplicate"):
        assemble(Surface(surface.points, *twice), grains)
