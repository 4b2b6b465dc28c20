"""Supports that a body lacks: as many as its free motions, and forces that would move it are refused."""

import numpy as np
import pytest
from structured_box import plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.rigid_body_supports import free_motions, lacking, rigid_motions, supported_bodies


def box(severed=False):
    crack = plane_crack(2, 2, lambda centres: np.ones(len(centres), bool)) if severed else None
    return assemble(*structured_box((3, 2, 4), lambda c: np.ones(len(c), int), crack, (1.0, 0.5, 2.0)))[0]


def test_rigid_motions_are_shifts_and_small_turns_about_the_middle():
    points = np.random.default_rng(1).normal(size=(20, 3))
    motions = rigid_motions(points)
    for axis in range(3):
        assert (motions[:, :, axis] == np.eye(3)[axis]).all()
        turn = np.cross(np.eye(3)[axis], points - points.mean(axis=0))
        assert motions[:, :, 3 + axis] == pytest.approx(turn, abs=1e-15)
    assert rigid_motions(points, np.zeros(3))[:, :, 5] == pytest.approx(np.cross([0, 0, 1], points))


# supports, motions that they leave free, and those of the upper half where the body is cut, off ZMIN
SUPPORTS = {
    "none": ([], 6, 6),
    "a plane across": ([("ZMIN", 2)], 3, 6),
    "two planes across": ([("ZMIN", 2), ("XMIN", 0)], 1, 3),
    "three planes across": ([("ZMIN", 2), ("XMIN", 0), ("YMIN", 1)], 0, 1),
    "a plane along itself": ([("ZMIN", 0)], 4, 6),
    "a plane in full": ([("ZMIN", 0), ("ZMIN", 1), ("ZMIN", 2)], 0, 6),
}


@pytest.mark.parametrize("name", SUPPORTS)
@pytest.mark.parametrize("severed", [False, True])
def test_a_body_gets_as_many_supports_as_motions_are_free(name, severed):
    planes, free, upper = SUPPORTS[name]
    mesh = box(severed)
    held = [(mesh.node_sets[plane], axis) for plane, axis in planes]
    found = lacking(mesh, held, np.zeros(mesh.points.shape))
    assert len(found) == free + upper * severed
    both = [*held, *((np.array([node]), axis) for node, axis in found)]
    assert all(len(free_motions(body.rows)) == 0 for body in supported_bodies(mesh, both))


def test_forces_that_balance_are_held_and_others_are_named_with_their_size():
    mesh = box()
    low, high = (np.flatnonzero((mesh.points == corner).all(axis=1))[0] for corner in mesh.box)
    forces = np.zeros(mesh.points.shape)
    span = mesh.points[high] - mesh.points[low]
    forces[high], forces[low] = span, -span
    assert len(lacking(mesh, [], forces)) == 6
    forces[high] = 0
    with pytest.raises(CraftmeshError, match="leave a force of -8 along z on the body"):
        lacking(mesh, [], forces)
    forces[high], forces[low] = [0, 5.0, 0], [0, -5.0, 0]  # 8 apart along z: a moment of -40 about x
    with pytest.raises(CraftmeshError, match="leave a moment of -40 about x on the body"):
        lacking(mesh, [(mesh.node_sets["ZMIN"], 0)], forces)
    assert lacking(mesh, [(mesh.node_sets["ZMIN"], axis) for axis in range(3)], forces) == []
