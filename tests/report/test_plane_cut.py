"""Cuts of tetrahedra by a plane: they lie in their tetrahedra, and their area is that of the section."""

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
    (a, b), (c, d) = (polygons[:, k + 2] - polygons[:, k] for k in (0, 1)), (0, 1)
    return np.abs(a[:, c] * b[:, d] - a[:, d] * b[:, c]) / 2


@given(st.floats(0.05, 0.95), st.sampled_from([(0, 12.0), (1, 8.0), (2, 6.0)]))
def test_a_cut_square_to_an_axis_has_the_area_of_the_section(share, case):
    axis, section = case
    points, tets = box_tets()
    level = share * [2.0, 3.0, 4.0][axis]
    polygons, rows = cut_tets(points, tets, level, axis)
    assert np.isclose(areas(polygons).sum(), section)
    assert (np.diff(rows) > 0).all()
    corners = np.delete(points[tets[rows]], axis, axis=2)
    assert (polygons >= corners.min(axis=1)[:, None] - 1e-12).all()
    assert (polygons <= corners.max(axis=1)[:, None] + 1e-12).all()


def test_a_plane_beside_the_body_cuts_nothing():
    points, tets = box_tets()
    polygons, rows = cut_tets(points, tets, 9.0, 0)
    assert len(polygons) == len(rows) == 0
