"""10-node tetrahedra: mid nodes on their edges, shared where faces are, apart on the lips."""

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.front_frames import front_frames
from craftmesh.mesh.second_order import raise_order
from craftmesh.mesh.tet_connectivity import FACE_CORNERS, face_nodes

# Abaqus: nodes 5..10 lie between these corners, counted from 1.
ABAQUS_EDGES = [(1, 2), (2, 3), (3, 1), (1, 4), (2, 4), (3, 4)]


def penny(shape=(6, 6, 4), spacing=(0.3, 0.7, 1 / 3)):
    one_grain = structured_box(
        shape, lambda c: np.ones(len(c), int), plane_crack(2, 2, hexagon((3, 3), 2)), spacing
    )
    return assemble(*one_grain)[0]


def test_mid_nodes_lie_midway_in_abaqus_order():
    linear = penny()
    mesh = raise_order(linear)
    assert (mesh.tets[:, :4] == linear.tets).all()
    assert (mesh.points[: len(linear.points)] == linear.points).all()
    for place, (a, b) in enumerate(ABAQUS_EDGES, 4):
        middle = 0.5 * (mesh.points[mesh.tets[:, a - 1]] + mesh.points[mesh.tets[:, b - 1]])
        assert (mesh.points[mesh.tets[:, place]] == middle).all()
    assert set(np.unique(mesh.tets)) == set(range(len(mesh.points)))


def test_elements_share_the_mid_nodes_of_their_common_faces():
    mesh = raise_order(penny())
    rows = np.stack(np.meshgrid(np.arange(len(mesh.tets)), np.arange(4), indexing="ij"), -1).reshape(-1, 2)
    nodes = face_nodes(mesh.tets, rows)
    mids = {}
    for corners, own in zip(map(frozenset, nodes[:, :3].tolist()), map(frozenset, nodes[:, 3:].tolist())):
        assert mids.setdefault(corners, own) == own
    assert len(mids) == len(np.unique(np.sort(mesh.tets[:, FACE_CORNERS].reshape(-1, 3), 1), axis=0))


def test_sets_hold_the_mid_nodes_of_their_faces():
    linear = penny()
    mesh = raise_order(linear)
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    for name in [name for name in mesh.node_sets if name[0] in "XYZ"]:
        on = np.ones(len(mesh.points), bool)
        for plane in name.split("_"):
            axis = "XYZ".index(plane[0])
            on &= mesh.points[:, axis] == (low if plane.endswith("MIN") else high)[axis]
        assert (np.flatnonzero(on) == mesh.node_sets[name]).all()
    a, b = (set(mesh.node_sets[f"CRACK_LIP_{side}"].tolist()) for side in "AB")
    assert a & b == set(mesh.node_sets["CRACK_FRONT"].tolist())
    where = [sorted(map(tuple, mesh.points[sorted(lip)].tolist())) for lip in (a, b)]
    assert where[0] == where[1]


def test_the_front_keeps_its_order_with_mids_between_corners():
    linear = penny()
    mesh = raise_order(linear)
    front, corners = mesh.node_sets["CRACK_FRONT"], linear.node_sets["CRACK_FRONT"]
    assert (front[::2] == corners).all()
    ring = linear.points[np.append(corners, corners[0])]
    assert (mesh.points[front[1::2]] == 0.5 * (ring[1:] + ring[:-1])).all()
    frames = front_frames(mesh)
    assert (frames.node == corners).all() and (frames.mid_node == front[1::2]).all()
    assert (np.diff(frames.s) > 0).all()
    assert np.allclose(np.abs(frames.normal), [0, 0, 1])


def test_an_edge_across_the_crack_between_two_front_nodes_opens():
    left, right = hexagon((2, 2), 1), hexagon((4, 3), 1)
    hourglass = plane_crack(2, 2, lambda c: left(c) | right(c))
    linear, report = assemble(*structured_box((6, 5, 4), lambda c: np.ones(len(c), int), hourglass))
    assert report["crack_facets_not_opened"] == 0 and report["fronts"] == 1
    mesh = raise_order(linear)
    waist = (mesh.points == [3, 2.5, 2]).all(axis=1)
    lips = [np.isin(np.flatnonzero(waist), mesh.node_sets[f"CRACK_LIP_{side}"]) for side in "AB"]
    assert waist.sum() == 2 and (lips[0] != lips[1]).all()
    a, b = (mesh.node_sets[f"CRACK_LIP_{side}"] for side in "AB")
    assert (np.intersect1d(a, b) == np.sort(mesh.node_sets["CRACK_FRONT"])).all()


def test_ten_node_meshes_are_refused():
    with pytest.raises(CraftmeshError, match="10-node"):
        raise_order(raise_order(penny()))
