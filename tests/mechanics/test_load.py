"""The load holds the body against every rigid motion, and once only."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.load import tension
from craftmesh.types import TetMesh


@pytest.fixture(scope="module")
def mesh() -> TetMesh:
    return assemble(*structured_box((3, 4, 5), lambda centres: np.ones(len(centres), int)))[0]


def rigid_motions(points: np.ndarray) -> np.ndarray:
    """Return the displacements (n, 3, 6) of three shifts and three small turns."""
    shifts = np.broadcast_to(np.eye(3), (len(points), 3, 3))
    turns = np.stack([np.cross(axis, points) for axis in np.eye(3)], axis=2)
    return np.concatenate([shifts, turns], axis=2)


def constraints(load, points) -> np.ndarray:
    """Return the rigid motions (c, 6) as the prescribed displacements see them."""
    motions = rigid_motions(points - points.mean(axis=0))
    return np.concatenate([motions[fixed.nodes, fixed.axis] for fixed in (*load.held, *load.moved)])


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("rollers", [False, True])
@pytest.mark.parametrize("by_stress", [False, True])
def test_no_rigid_motion_is_free(mesh, axis, rollers, by_stress):
    load = tension(mesh, axis, 0.01, by_stress=by_stress, rollers=rollers)
    assert np.linalg.matrix_rank(constraints(load, mesh.points)) == 6
    assert all(fixed.displacement == 0 for fixed in load.held)


def test_without_rollers_a_free_body_is_held_by_no_more_than_its_plane_and_three_more(mesh):
    load = tension(mesh, 1, 0.01, by_stress=True, rollers=False)
    plane, *single = load.held
    assert (plane.name, plane.axis) == ("YMIN", 1)
    assert np.array_equal(plane.nodes, mesh.node_sets["YMIN"])
    assert [len(fixed.nodes) for fixed in single] == [1, 1, 1]
    assert np.linalg.matrix_rank(constraints(load, mesh.points)[len(plane.nodes) :]) == 3


def test_the_far_plane_moves_by_the_strain_or_is_pulled_by_the_stress(mesh):
    (moved,) = tension(mesh, 2, 0.01, by_stress=False, rollers=True).moved
    assert (moved.name, moved.axis) == ("ZMAX", 2)
    assert moved.displacement == pytest.approx(0.01 * np.ptp(mesh.points[:, 2]))
    load = tension(mesh, 2, 250, by_stress=True, rollers=True)
    (pulled,) = load.pulled
    assert not load.moved and (pulled.name, pulled.stress) == ("ZMAX", 250.0)
    assert np.array_equal(pulled.faces, mesh.face_sets["ZMAX"])


def test_a_plane_without_nodes_is_named(mesh):
    sets = {name: nodes for name, nodes in mesh.node_sets.items() if name != "XMIN"}
    open_mesh = TetMesh(mesh.points, mesh.tets, mesh.grain, sets, mesh.face_sets)
    with pytest.raises(CraftmeshError, match="XMIN"):
        tension(open_mesh, 2, 0.01, by_stress=False, rollers=True)
