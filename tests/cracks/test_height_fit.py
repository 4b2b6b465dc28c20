"""Heights fitted to measured points: planes, waves that the stiffness takes, and places between points."""

import numpy as np
import pytest
import shapely

from craftmesh.cracks.height_fit import fitted_heights, interpolation
from craftmesh.cracks.in_plane import filled


def sheet(width: float, depth: float, spacing: float):
    return filled(shapely.box(0, 0, width, depth), np.zeros((0, 2)), spacing)


def test_a_plane_comes_out_from_few_points_with_and_without_fixed_heights():
    points, triangles = sheet(4.0, 3.0, 0.5)
    rng = np.random.default_rng(1)
    places = rng.uniform([0.1, 0.1], [3.9, 2.9], (7, 2))
    plane = points @ [0.3, -0.7] + 2
    measured = np.column_stack([places, places @ [0.3, -0.7] + 2])
    off = np.vstack([measured, [9.0, 9.0, 50.0]])  # one off the triangles does not count
    fixed = np.where(np.arange(len(points)) % 17 == 0, plane, np.nan)
    free = np.full(len(points), np.nan)
    for kept, given in ((free, off), (fixed, off), (fixed, measured[:0])):
        assert fitted_heights(points, triangles, kept, given, 0.5) == pytest.approx(plane, abs=1e-7)
    assert np.array_equal(fitted_heights(points, triangles, plane, measured + 5, 0.5), plane)


def test_fixed_heights_stay_whatever_is_measured():
    points, triangles = sheet(4.0, 3.0, 0.5)
    fixed = np.where(points[:, 0] < 1.0, 0.0, np.nan)
    measured = np.column_stack([points, np.ones(len(points))])
    heights = fitted_heights(points, triangles, fixed, measured, 0.5)
    assert np.array_equal(heights[points[:, 0] < 1.0], np.zeros((points[:, 0] < 1.0).sum()))
    assert heights[points[:, 0] > 3.5] == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("unit, count", [(1.0, 0), (1e-3, 9000)])
def test_the_stiffness_halves_one_wave_whatever_the_unit_and_the_number_of_points(unit, count):
    """The hinge energy of a sheet of equilateral triangles is three times the square of its curvature."""
    spacing = 8.0 * unit
    length = 2 * np.pi * 3**0.25 / 4 * spacing
    ends = np.array([4 * length, 2 * length])
    points, triangles = sheet(*ends, spacing / 10)
    places = np.random.default_rng(2).uniform(0, ends, (count, 2)) if count else points
    wave = unit * np.sin(2 * np.pi * places[:, 0] / length)
    free = np.full(len(points), np.nan)
    heights = fitted_heights(points, triangles, free, np.column_stack([places, wave]), spacing)
    inner = ((points > length / 2) & (points < ends - length / 2)).all(axis=1)
    known = unit * np.sin(2 * np.pi * points[inner, 0] / length)
    # 0.02: edges of a twentieth of the wave, and points at random
    assert heights[inner] @ known / (known @ known) == pytest.approx(0.5, abs=0.02)


def test_what_interpolates_is_exact_for_heights_of_a_plane_and_tells_its_triangle():
    points, triangles = sheet(4.0, 3.0, 0.7)
    rng = np.random.default_rng(3)
    places = rng.uniform([-1, -1], [5, 4], (300, 2))
    row, triangle, at = interpolation(points, triangles, places)
    inside = ((places >= 0) & (places <= [4, 3])).all(axis=1)
    assert np.array_equal(row, np.flatnonzero(inside))
    assert at @ points == pytest.approx(places[row])
    assert at.min() >= -1e-12
    corners = shapely.polygons(points[triangles[triangle]])
    assert shapely.distance(corners, shapely.points(places[row])).max() < 1e-12
    # within a distance, those beside the sheet lie on it too, and its planes go on
    near, _, at = interpolation(points, triangles, places, 0.5)
    off = np.linalg.norm(places - np.clip(places, 0, [4, 3]), axis=1)
    assert np.array_equal(near, np.flatnonzero(off <= 0.5))
    assert at @ points == pytest.approx(places[near])
