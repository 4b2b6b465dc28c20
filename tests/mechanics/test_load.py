"""The load holds the body against every rigid motion, and once only."""

import numpy as np
import pytest
from structured_box import structured_box
from warped_cracks import disc_crack

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.load import Traction, face_loop, nodal_forces, tension
from craftmesh.mesh.integration import corner_shares, face_points
from craftmesh.mesh.mesh_sets import LIPS
from craftmesh.mesh.second_order import as_elements
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.types import BOX_PLANES, TetMesh


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


@pytest.mark.parametrize("lip", LIPS)
@pytest.mark.parametrize(("element", "quarter_points"), [("C3D4", 0), ("C3D10", 0), ("C3D10", 1)])
def test_forces_of_a_linear_traction_have_its_resultant_and_its_moment(element, quarter_points, lip):
    """Of each facet; at the front mid nodes are at quarter points, where parameters are no areas."""
    mesh, report = as_elements(disc_crack(2, 1, 1), element, bool(quarter_points))
    assert bool(report.get("quarter_points")) == bool(quarter_points)
    slope, start = np.random.default_rng(2).normal(size=(3, 3)), np.array([1.0, -2.0, 0.5])
    for face in mesh.face_sets[lip]:
        nodes = face_nodes(mesh.tets, face[None])
        corners = mesh.points[nodes[0, :3]]
        pull = face_points(mesh.points[nodes]).place @ slope + start
        tractions = [Traction(face[None], pull[:, :, axis], lip, axis) for axis in range(3)]
        forces = nodal_forces(tractions, mesh)
        area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) / 2
        places = (corners + np.roll(corners, 1, axis=0)) / 2  # a rule that is exact to degree 2
        exact = area / 3 * (places @ slope + start)
        scale = np.abs(exact).sum()
        assert forces.sum(axis=0) == pytest.approx(exact.sum(axis=0), abs=1e-12 * scale)
        moment = np.cross(mesh.points, forces).sum(axis=0)
        # of degree 6 in the parameters where there are quarter points, one more than the rule's: measured
        # 1.3e-7; with the traction linear in the parameters 0.06, and 0.11 of the resultant
        assert moment == pytest.approx(np.cross(places, exact).sum(axis=0), abs=1e-6 * scale)


def test_shares_of_corners_are_linear_in_space():
    rng = np.random.default_rng(3)
    corners, shares = rng.normal(size=(5, 3, 3)), rng.dirichlet(np.ones(3), size=(5, 4))
    assert np.allclose(corner_shares(corners, shares @ corners), shares)


@pytest.mark.parametrize("plane", BOX_PLANES)
def test_strain_and_stress_of_a_face_are_positive_where_it_is_pulled_outwards(mesh, plane):
    across, outwards = BOX_PLANES.index(plane) // 2, 1.0 if plane.endswith("MAX") else -1.0
    nodes, lengths = mesh.node_sets[plane], np.ptp(mesh.points, axis=0)
    for axis in range(3):
        way = np.eye(3)[axis] * outwards
        moved = np.array([0.0, 2e-3, -1e-3])[:, None, None] * np.broadcast_to(way, (3, len(nodes), 3))
        force = np.array([0.0, 50.0, -20.0])[:, None] * way
        found = face_loop(mesh, plane, axis, nodes, moved, force)
        name, section = f"{plane}.{'xyz'[axis]}", np.delete(lengths, across).prod()
        assert list(found) == [f"{name} strain", f"{name} stress"]
        assert found[f"{name} strain"] == pytest.approx(np.array([0, 2e-3, -1e-3]) / lengths[across])
        assert found[f"{name} stress"] == pytest.approx(np.array([0, 50, -20]) / section)
