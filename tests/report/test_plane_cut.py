"""Cuts of tetrahedra by a plane: they lie in it, and their area is that of the body's section."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from structured_box import structured_box

from craftmesh.report.shown_mesh import cut_tets


def box_tets():
    surface, grains = structured_box((2, 3, 4), lambda centres: np.ones(len(centres), int))
    mesh = grains[0]
    return np.concatenate([surface.points[mesh.nodes], mesh.interior]), mesh.tets


def areas(polygons):
    return (
        np.linalg.norm(np.cross(polygons[:, 2] - polygons[:, 0], polygons[:, 3] - polygons[:, 1]), axis=1)
        / 2
    )


@given(st.floats(0.05, 0.95), st.sampled_from([(0, 12.0), (1, 8.0), (2, 6.0)]))
def test_a_cut_square_to_an_axis_has_the_area_of_the_section(share, case):
    axis, section = case
    points, tets = box_tets()
    place = share * np.array([2.0, 3.0, 4.0])
    polygons, rows = cut_tets(points, tets, place, np.eye(3)[axis])
    assert np.isclose(areas(polygons).sum(), section)
    assert np.allclose(polygons[..., axis], place[axis])
    assert (np.diff(rows) > 0).all()


@given(st.floats(-1, 1), st.floats(-1, 1))
def test_polygons_lie_in_the_plane_and_in_their_tetrahedron(u, v):
    points, tets = box_tets()
    normal = np.array([u, v, 1.0])
    origin = np.array([1.0, 1.5, 2.03])
    polygons, rows = cut_tets(points, tets, origin, normal)
    assert np.abs((polygons - origin) @ normal).max() < 1e-12
    corners = points[tets[rows]]
    assert (polygons >= corners.min(axis=1)[:, None] - 1e-12).all()
    assert (polygons <= corners.max(axis=1)[:, None] + 1e-12).all()


def test_a_plane_beside_the_body_cuts_nothing():
    points, tets = box_tets()
    polygons, rows = cut_tets(points, tets, np.array([9.0, 0, 0]), np.array([1.0, 0, 0]))
    assert len(polygons) == len(rows) == 0
