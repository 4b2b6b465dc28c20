"""Edges in narrow strips between a crack and a face of the box; wedges and wide places are left alone."""

import numpy as np
import pytest

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.sizing.sizing import Sizing
from craftmesh.sizing.strips import (
    PER_WIDTH,
    PER_WIDTH_IN_WEDGE,
    SHORTEST_IN_SLIVERS,
    strip_lengths,
)

BOX = np.array([[0.0, 0, 0], [40, 40, 20]])


def penny(height: float, degrees: float = 0.0, centre: tuple = (20.0, 20.0), radius: float = 12.0):
    normal = (0.0, np.sin(np.radians(degrees)), np.cos(np.radians(degrees)))
    options = CrackOptions(centre=(*centre, height), normal=normal, radius=radius)
    return prescribed_crack(options, 0, BOX)


def plate(corners, rows: int, columns: int):
    """A crack on a grid over the quadrilateral of four corners."""
    u, v = (
        one.ravel()[:, None] for one in np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    )
    a, b, c, d = np.array(corners, float)
    points = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower = np.stack([corner, corner + 1, corner + columns + 1], axis=1)
    triangles = np.concatenate([lower, np.stack([corner, corner + columns + 1, corner + columns], axis=1)])
    return crack_from_triangles(points, triangles, None, BOX)


def sizing_around(crack, growth=None) -> Sizing:
    fronts = np.concatenate([crack.points[front] for front in crack.fronts])
    return Sizing(0.5, 2.0, 6.0, 4.0, 8.0, 1.0, fronts, growth)


def found(crack, growth=None):
    return strip_lengths(crack, BOX, sizing_around(crack, growth))


@pytest.mark.parametrize("width", [0.3, 0.8, 1.5])
@pytest.mark.parametrize("top", [False, True])
def test_edges_over_a_strip_are_a_share_of_its_width(width, top):
    crack = penny(20 - width if top else width)
    strips = found(crack)
    middle = np.array([[20.0, 20.0, 20 - width if top else width]])
    assert np.allclose(strips.lengths, PER_WIDTH * width, rtol=1e-9)
    # no place is farther than l_min from the next sample, and lengths grow by half the distance
    assert strips.lengths[0] <= strips.at(middle)[0] < strips.lengths[0] + 0.25
    # far from the crack the strip is wide: the growth brings the lengths back to those of Eq. 3
    assert strips.at(np.array([[20.0, 20.0, 10.0]]))[0] > 5.0


def test_no_edge_is_shorter_than_half_of_l_min():
    assert found(penny(0.05)).lengths.min() == 0.25


def test_lengths_grow_by_the_limit_that_is_given():
    strips = found(penny(0.8), growth=0.2)
    assert strips.growth == 0.2
    above = np.array([[20.0, 20.0, 0.8], [20.0, 20.0, 5.8]])
    assert np.diff(strips.at(above))[0] == pytest.approx(0.2 * 5.0, rel=0.05)


@pytest.mark.parametrize("degrees", [8.0, 20.0, 45.0, 90.0])
def test_a_wedge_at_a_mouth_is_no_strip(degrees):
    crack = penny(0.0, degrees, radius=12.0)
    assert found(crack) is None


def test_a_crack_across_the_box_and_one_far_from_its_faces_have_no_strips():
    across = CrackOptions(shape="through_edge", centre=(0, 20, 10), normal=(0, 0, 1), radius=15.0)
    assert found(prescribed_crack(across, 0, BOX)) is None
    assert found(penny(10.0, radius=6.0)) is None


def test_beside_its_mouth_a_kinked_crack_leaves_a_strip():
    """A square that is level .8 over the face, and beyond a kink goes down to it at 45 degrees."""
    crack = plate([(8, 8, 0.8), (32, 8, 0.8), (32, 32, 0.8), (8, 32, 0.8)], 25, 25)
    points = crack.points - np.maximum(crack.points[:, :1] - 25.0, 0.0) * (0, 0, 1)
    strips = found(crack_from_triangles(points, crack.triangles, None, BOX))
    level = strips.points[:, 0] < 25
    assert np.allclose(strips.lengths[level], PER_WIDTH * 0.8) and level.any()
    # where it goes down to the face it makes a wedge
    assert strips.points[:, 0].max() < 25.5


def test_a_crack_that_cuts_off_an_edge_of_the_box_is_a_strip_between_its_mouths():
    """It runs up from z = 0 to a front at z = 12; its mouths are .8 apart."""
    a, b = 0.8 / np.sqrt(2) + 1.0, -1.0
    crack = plate([(a, b, -1), (b, a, -1), (b, a, 12), (a, b, 12)], 40, 12)
    strips = found(crack)
    low = strips.points[:, 2] < 6
    assert low.any() and np.allclose(strips.lengths[low], PER_WIDTH * 0.8, rtol=0.3)
    # each mouth is nearer to the edge of the box than to the other mouth
    assert strips.lengths[low].min() >= PER_WIDTH * 0.8 / np.sqrt(2) * (1 - 1e-9)


def test_a_corner_of_a_crack_is_no_strip():
    """A plate square to two faces: its mouths meet at an edge of the box at a right angle."""
    assert found(plate([(-1, -1, 9), (14, -1, 9), (14, 14, 9), (-1, 14, 9)], 12, 12)) is None


@pytest.mark.parametrize("gap", [0.02, 0.1, 0.15])
def test_a_front_that_comes_near_a_face_has_edges_of_a_share_of_the_gap(gap):
    crack = penny(10.0, degrees=90.0, centre=(12.0 + gap, 20.0), radius=12.0)
    strips = found(crack)
    near = np.array([[gap, 20.0, 10.0]])
    # places along the front are 0.2 l_min apart; on a front of radius 12 the next is .0004 farther off
    assert strips.at(near)[0] == pytest.approx(max(PER_WIDTH * gap, SHORTEST_IN_SLIVERS * 0.5), abs=0.06)


@pytest.mark.parametrize("gap", [0.1, 0.3])
def test_a_mouth_beside_an_edge_of_the_box_has_edges_of_a_share_of_the_gap(gap):
    """A plane at 45 degrees to two faces that goes from its mouth on y = 0 to a front at y = 9."""
    crack = plate([(gap - 1, -1, 8), (gap - 1, -1, 12), (gap + 9, 9, 12), (gap + 9, 9, 8)], 20, 40)
    strips = found(crack)
    at = strips.at(np.array([[gap, 0.0, z] for z in (9.0, 10.0, 11.0)]))
    assert at == pytest.approx(np.full(3, PER_WIDTH * gap), abs=0.06)


@pytest.mark.parametrize("gap", [0.02, 0.03])
def test_beside_a_wedge_edges_are_a_larger_share_of_the_gap(gap):
    """A plane at under 20 degrees to the face x = 0 that leaves the gap at its mouth on y = 0."""
    flat = plate(
        [(gap - 0.36, -1, 8), (gap - 0.36, -1, 12), (gap + 3.24, 9, 12), (gap + 3.24, 9, 8)], 20, 40
    )
    assert found(flat).lengths.min() == pytest.approx(PER_WIDTH_IN_WEDGE * gap, rel=1e-6)


def test_where_the_crack_lies_flat_beside_its_steep_mouth_there_is_no_sliver():
    """From its mouth it goes up at 45 degrees by 0.2, then on at 10 degrees to the face."""
    gap = 0.05
    crack = plate([(gap - 1, -1, 8), (gap - 1, -1, 12), (gap + 9, 9, 12), (gap + 9, 9, 8)], 80, 20)
    assert found(crack).lengths.min() == pytest.approx(PER_WIDTH * gap)
    points = crack.points.copy()
    points[:, 1] = np.minimum(points[:, 1], 0.2 + np.tan(np.radians(10)) * (points[:, 1] - 0.2))
    beside = found(crack_from_triangles(points, crack.triangles, None, BOX))
    # where its front meets the face is a corner
    assert beside.lengths[np.abs(beside.points[:, 2] - 10) < 1.5].min() >= 0.25


def test_a_mouth_that_leads_to_an_edge_makes_a_corner_and_no_sliver():
    assert found(plate([(-1, -1, 9), (14, -1, 9), (14, 10, 14), (-1, 10, 14)], 12, 12)) is None
