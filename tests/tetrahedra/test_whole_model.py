"""pytetwild's mesh of a whole model: conformal, with grains, box planes, voids and crack found again."""

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.tet_connectivity import group_triples, half_face_corners, half_faces, tet_volumes
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.labels import labels_at
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.whole.crack_faces import crack_half_faces, recovery_of_crack
from craftmesh.tetrahedra.whole.new_surface import move_onto_planes
from craftmesh.tetrahedra.whole.whole_model import mesh_whole_model
from craftmesh.types import CRACK, Surface

OPTIONS = TetrahedralizeOptions(envelope=0.1)


def cracked_box():
    """Grains 3 and 8 along x, the void 1 in grain 3, and a crack in z = 3 across both grains."""

    def label_of(c):
        label = np.where(c[:, 0] < 4, 3, 8)
        return np.where((np.abs(c - [1.5, 1.5, 1.5]) < 0.6).all(1), -1, label)

    crack = plane_crack(2, 3, hexagon((4.0, 3.0), 2.1))
    return structured_box((8, 6, 6), label_of, crack)[0]


@pytest.fixture(scope="module")
def pierced():
    """The box with a corner of the void pulled through the boundary of the grains."""
    surface = cracked_box()
    points = surface.points.copy()
    corner = np.flatnonzero((points == [2, 2, 2]).all(axis=1))
    assert len(corner) == 1
    points[corner] = [4.4, 2.2, 1.6]
    result = Surface(points, surface.facets, surface.sides, surface.kind)
    assert "intersect" in check_surface(result)[0]
    return result


@pytest.fixture(scope="module")
def remade(pierced):
    return mesh_whole_model(pierced, None, OPTIONS)


def test_a_surface_that_intersects_itself_becomes_a_sound_mesh(pierced, remade):
    surface, grain_tets, report = remade
    assert check_surface(surface) == []
    mesh, opened = assemble(surface, grain_tets)
    assert check_tets(mesh) == []
    assert [grain.grain for grain in grain_tets] == [3, 8]
    assert (
        opened["crack_facets_not_opened"] == 0 and opened["nodes_unwelded"] == 0 and opened["fronts"] == 1
    )
    assert {"CRACK_LIP_A", "CRACK_LIP_B", "VOID_1", "XMIN", "ZMAX"} <= mesh.face_sets.keys()
    assert "EXTERIOR" not in mesh.face_sets


def test_planes_are_exact_and_volumes_and_crack_are_kept(pierced, remade):
    surface, grain_tets, report = remade
    assert surface.points.min(axis=0).tolist() == [0, 0, 0]
    assert surface.points.max(axis=0).tolist() == [8, 6, 6]
    for one, volume in zip(grain_tets, (143.0, 144.0)):
        points = np.concatenate([surface.points[one.nodes], one.interior])
        # the void's spike takes less than a cell
        assert abs(tet_volumes(points, one.tets).sum() / volume - 1) < 0.02
    area = [np.isin(s.kind, CRACK).sum() for s in (pierced, surface)]
    assert min(area) > 0 and abs(report["crack_area"] / report["crack_area_before"] - 1) < 0.03
    # the front is put on the given one, up to the sagitta of its corners
    assert report["front_off"] < 0.3


def test_a_crack_that_is_not_found_again_is_an_error(pierced, remade):
    surface = remade[0]
    kept = np.flatnonzero(surface.kind != CRACK)
    without = Surface(surface.points, surface.facets[kept], surface.sides[kept], surface.kind[kept])
    with pytest.raises(CraftmeshError, match="keeps 0 of the crack's area"):
        recovery_of_crack(pierced, without)


def test_a_mesh_in_which_grains_are_not_found_is_tried_again_with_half_the_envelope(monkeypatch):
    surface = structured_box((2, 1, 1), lambda c: 1 + c[:, 0].astype(int))[0]
    tried = []

    def fake_run(task, options):
        tried.append(task.envelope)
        points, tets = np.eye(4, 3) * 0.3 + 0.1, np.array([[0, 1, 2, 3]])
        return points, tets[:, [0, 2, 1, 3]], 0.0

    monkeypatch.setattr("craftmesh.tetrahedra.whole.whole_model._run", fake_run)
    with pytest.raises(CraftmeshError, match="grain 2 is lost"):
        mesh_whole_model(surface, None, OPTIONS)
    assert len(tried) == 2 and tried[1] == tried[0] / 2


def test_a_time_limit_ends_it_with_one_line():
    with pytest.raises(CraftmeshError, match="whole model: gave no answer within 0.2 s") as caught:
        mesh_whole_model(cracked_box(), None, TetrahedralizeOptions(whole_time_limit=0.2))
    assert "\n" not in str(caught.value)


def test_labels_are_those_of_the_cells():
    rng = np.random.default_rng(5)
    table = rng.choice([0, 2, 5, 9], (5, 5, 5))
    core = table[1:4, 1:4, 1:4]
    core[core == 0] = 5
    core[1, 1, 1] = -1

    def label_of(c):
        return table[tuple(c.astype(int).T)]

    surface = structured_box(table.shape, label_of)[0]
    places = rng.uniform(-0.5, 1.1, (3000, 3)) * table.shape
    inside = ((places >= 0) & (places < table.shape)).all(axis=1)
    expected = np.zeros(len(places), int)
    expected[inside] = label_of(places[inside])
    assert -1 in expected
    assert np.array_equal(labels_at(places, surface.points, surface.facets, surface.sides), expected)


def test_points_near_planes_are_put_on_them_and_flat_tets_go_outside():
    surface, (grain,) = structured_box((2, 2, 2), lambda c: np.ones(len(c), int))
    points = np.concatenate([surface.points[grain.nodes], grain.interior])
    rng = np.random.default_rng(1)
    shaken = points + rng.uniform(-1e-3, 1e-3, points.shape)
    on_top = np.flatnonzero(points[:, 2] == 2)[:3]
    apex = shaken[on_top].mean(axis=0) + [0, 0, 1e-4]
    shaken = np.concatenate([shaken, [apex]])
    # a tet that stands on the top within the reach
    tets = np.concatenate([grain.tets, [[*on_top, len(points)]]])
    labels = np.ones(len(tets), np.int64)
    moved, found, report = move_onto_planes(surface, shaken, tets, labels, 2e-3)
    is_outer = ((points == 0) | (points == 2)).any(axis=1)
    assert np.array_equal(moved[: len(points)][is_outer] % 2 == 0, points[is_outer] % 2 == 0)
    assert found.tolist() == [*labels[:-1], 0]
    with pytest.raises(CraftmeshError, match="turn over"):
        move_onto_planes(surface, shaken, grain.tets, labels[:-1], 1.2)


def test_crack_faces_are_those_of_a_structured_mesh():
    surface, grains = structured_box(
        (4, 4, 4), lambda c: np.ones(len(c), int), plane_crack(2, 2, hexagon((2.0, 2.0), 1.2))
    )
    (grain,) = grains
    points = np.concatenate([surface.points[grain.nodes], grain.interior])
    pairs = group_triples(half_faces(grain.tets)).pairs
    rows = crack_half_faces(surface, points, grain.tets, pairs, 0.05)
    found = np.sort(points[half_face_corners(grain.tets, rows)].mean(axis=1), axis=0)
    wanted = np.sort(surface.points[surface.facets[surface.kind == CRACK]].mean(axis=1), axis=0)
    assert np.allclose(found, wanted) and len(found)
    # all are faces of the tets above
    assert (points[grain.tets[rows // 4]].mean(axis=1)[:, 2] > 2).all()
