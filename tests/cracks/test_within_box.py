"""What of a crack lies in the box: areas, mouths and tilts against shapely and plain geometry."""

import numpy as np
import pytest
from shapely import MultiPoint, Polygon, box

from craftmesh.cracks.near_faces import cuts, in_plane
from craftmesh.cracks.within_box import (
    area_off,
    area_within,
    clipped,
    is_in,
    is_in_material,
    polygon_area,
    segments_of,
    tilts,
)
from craftmesh.types import Crack, Voxels

BOX = np.array([[0.0, -1.0, 2.0], [3.0, 1.0, 4.0]])
INSIDE = box(0, -1, 3, 1)


def slanted(triangles, slope):
    """Triangles (n, 3, 2) over x and y, lifted onto z = 3 + a x + b y."""
    return np.concatenate([triangles, (3 + triangles @ slope)[..., None]], axis=2)


@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.3, -0.2), (-1.5, 2.0)])
def test_the_area_in_the_box_is_that_of_the_cut_seen_from_above(slope):
    rng = np.random.default_rng(3)
    flat, slope = rng.uniform([-2, -3], [5, 3], (60, 3, 2)), np.array(slope)
    corners = slanted(flat, slope)
    # between the planes z = 2 and 4 lies the strip |a x + b y| <= 1
    across = np.array([-slope[1], slope[0]])
    strip = INSIDE
    if slope.any():
        ends = [
            slope * way / (slope @ slope) + far * across
            for way, far in ((-1, -9), (-1, 9), (1, 9), (1, -9))
        ]
        strip = INSIDE.intersection(Polygon(ends))
    stretch = np.sqrt(1 + slope @ slope)
    for own, triangle in zip(flat, corners):
        known = strip.intersection(Polygon(own)).area * stretch
        crack = Crack(triangle, np.array([[0, 1, 2]]), ())
        assert area_within(crack, BOX) == pytest.approx(known, abs=1e-9)
        assert is_in(triangle[None], BOX) == (known > 1e-9)
        part = clipped(triangle, BOX)
        assert (part >= BOX[0] - 1e-12).all() and (part <= BOX[1] + 1e-12).all()
        assert (polygon_area(part) if len(part) > 2 else 0.0) == pytest.approx(known, abs=1e-9)
    whole = Crack(corners.reshape(-1, 3), np.arange(180).reshape(-1, 3), ())
    total = sum(strip.intersection(Polygon(own)).area for own in flat) * stretch
    assert area_within(whole, BOX) == pytest.approx(total)


@pytest.mark.parametrize("face", [(axis, upper) for axis in range(3) for upper in (0, 1)])
def test_mouths_are_the_segments_in_which_triangles_meet_a_plane(face):
    axis, upper = face
    corners = np.random.default_rng(axis).uniform(BOX[0] - 1, BOX[1] + 1, (200, 3, 3))
    found = cuts(corners, BOX, face)
    assert np.abs(found[..., axis] - BOX[upper, axis]).max() < 1e-12
    height = corners[..., axis] - BOX[upper, axis]
    known = []
    for triangle, h in zip(corners, height):
        pairs = [(i, j) for i, j in ((0, 1), (1, 2), (2, 0)) if h[i] * h[j] < 0]
        if pairs:
            ends = np.array([(triangle[i] * h[j] - triangle[j] * h[i]) / (h[j] - h[i]) for i, j in pairs])
            low, high = ends.min(axis=0), ends.max(axis=0)
            known += [ends] * bool(((low <= BOX[1]) & (high >= BOX[0]))[np.arange(3) != axis].all())
    assert len(found) == len(known) > 20
    for one, other in zip(found, known):
        assert min(np.abs(one - other).max(), np.abs(one - other[::-1]).max()) < 1e-9
    away = in_plane(corners[:, 0], corners[:, 1], BOX, face)
    assert (np.isnan(away).any(axis=1) == (height[:, 0] * height[:, 1] > 0)).all()


def test_tilts_are_the_angles_to_the_faces():
    for degrees in (0.0, 20.0, 75.0):
        turn = np.radians(degrees)
        points = np.array([[0, 0, 0], [np.cos(turn), 0, np.sin(turn)], [0, 1, 0]])
        for triangles in ([[0, 1, 2]], [[0, 2, 1]]):  # whichever way it looks
            found = tilts(Crack(points, np.array(triangles), ()))
            assert found[0] == pytest.approx([90 - degrees, 90, degrees], abs=1e-5)


def test_areas_between_a_circle_and_its_chords_count_for_nothing():
    turn = np.radians(np.arange(0, 361, 10))
    circle = 5 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    chords = np.stack([circle[:-1], circle[1:]], axis=1)
    off = np.full(36, 5 * (1 - np.cos(np.radians(5))))
    # parabolas in place of arcs: 1e-3 of the area between
    between = segments_of(chords, off)
    polygon = MultiPoint(circle[:, :2]).convex_hull.area
    assert between == pytest.approx(25 * np.pi - polygon, rel=2e-3)
    assert area_off(polygon, 25 * np.pi, between, 1.0) < 0.02 < 1 < area_off(polygon, 25 * np.pi, 0.0, 0.1)
    assert segments_of(chords[:0], off[:0]) == 0.0


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("below", [False, True])
def test_a_crack_lies_in_material_where_any_of_its_part_in_the_box_lies_in_a_grain(axis, below):
    """A volume that is empty from its middle on, or below, and a square across x, y or z."""
    origin, spacing = np.array([3.0, -5.0, 20.0]), np.array([0.5, 1.0, 2.0])
    labels = np.ones((8, 8, 8), int)
    labels[(slice(None),) * axis + (slice(4) if below else slice(4, None),)] = 0
    voxels = Voxels(labels, tuple(spacing), tuple(origin))
    plane = np.delete(np.arange(3), axis)
    square = np.full((4, 3), 4.0)
    square[:, plane] = np.array([[2.0, 2], [4, 2], [4, 4], [2, 4]])
    for height, known in ((3.9, True), (4.1, False), (7.9, False), (0.1, True), (-0.1, True), (8.1, True)):
        # in voxels; a crack outside the box is another's to refuse
        square[:, axis] = 8 - height if below else height
        crack = Crack(origin + spacing * square, np.array([[0, 1, 2], [0, 2, 3]]), ())
        assert is_in_material(crack, voxels) == known
    across = np.delete(np.arange(3), axis)[0]
    square = np.full((4, 3), 1.0)
    # an eighth of its area lies on one side of the middle
    square[:, [axis, across]] = np.array([[3.5, 2.0], [7.5, 2], [7.5, 4], [3.5, 4]])
    assert is_in_material(Crack(origin + spacing * square, np.array([[0, 1, 2], [0, 2, 3]]), ()), voxels)
