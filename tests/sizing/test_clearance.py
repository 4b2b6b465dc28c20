"""Edges where a crack comes near to a face or to another sheet: a share of the way; else as they were."""

import numpy as np
import pytest
from given_cracks import over_grid

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.sheets import one_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.sizing.clearance import (
    PER_WIDTH,
    PER_WIDTH_IN_WEDGE,
    SHORTEST,
    SHORTEST_BESIDE_LINES,
    clearance_lengths,
    kink_edges,
)
from craftmesh.sizing.sizing import FREE_GROWTH, Sizing
from craftmesh.types import Crack

BOX = np.array([[0.0, 0, 0], [40, 40, 20]])
L_MIN = 0.5
APART = FREE_GROWTH * L_MIN  # places are up to l_min apart, and lengths grow by half the distance


def penny(height: float, degrees: float = 0.0, centre: tuple = (20.0, 20.0), radius: float = 12.0) -> Crack:
    normal = (0.0, np.sin(np.radians(degrees)), np.cos(np.radians(degrees)))
    options = CrackOptions(centre=(*centre, height), normal=normal, radius=radius)
    return prescribed_crack(BOX, options)


def plate(corners, rows: int = 20, columns: int = 40) -> Crack:
    """A crack on a grid over the quadrilateral of four corners."""
    v, u = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing="ij")
    a, b, c, d = (np.array(corner, float)[:, None, None] for corner in corners)
    places = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
    return crack_from_triangles(*over_grid(*places), None, BOX)


def found(crack: Crack, growth=None):
    fronts = np.concatenate([np.zeros((0, 3)), *(crack.points[front] for front in crack.fronts)])
    return clearance_lengths(crack, BOX, Sizing(L_MIN, 2.0, 6.0, 4.0, 8.0, 1.0, fronts, growth))


@pytest.mark.parametrize("width", [0.05, 0.3, 0.8, 1.5])
@pytest.mark.parametrize("top", [False, True])
def test_edges_between_a_crack_and_a_face_are_a_share_of_the_way(width, top):
    height = 20 - width if top else width
    lengths = found(penny(height))
    wished = max(PER_WIDTH * width, SHORTEST * L_MIN)
    # inside of the front, beside which edges may be shorter
    assert wished * (1 - 1e-9) <= lengths.at(np.array([[20.0, 20.0, height]]))[0] < wished + APART
    # far from the crack the growth brings the lengths back to those of Eq. 3
    assert lengths.at(np.array([[20.0, 20.0, 10.0]]))[0] > 5.0


def test_lengths_grow_by_the_limit_that_is_given():
    lengths = found(penny(0.8), growth=0.2)
    above = np.array([[20.0, 20.0, 0.8], [20.0, 20.0, 5.8]])
    assert np.diff(lengths.at(above))[0] == pytest.approx(0.2 * 5.0, rel=0.05)


@pytest.mark.parametrize("degrees", [8.0, 20.0, 45.0, 90.0])
def test_a_wedge_at_a_mouth_keeps_its_lengths(degrees):
    assert found(penny(0.0, degrees)) is None


def test_cracks_across_the_box_or_far_from_faces_or_into_its_edges_keep_their_lengths():
    across = CrackOptions(shape="through_edge", centre=(0, 20, 10), normal=(0, 0, 1), radius=15.0)
    assert found(prescribed_crack(BOX, across)) is None
    assert found(penny(10.0, radius=6.0)) is None
    assert found(plate([(-1, -1, 9), (14, -1, 9), (14, 14, 9), (-1, 14, 9)])) is None
    assert found(plate([(-1, -1, 9), (14, -1, 9), (14, 10, 14), (-1, 10, 14)])) is None


def test_beside_its_mouth_a_kinked_crack_leaves_a_strip():
    """A square that is level .8 over the face, and beyond a kink goes down to it at 45 degrees."""
    crack = plate([(8, 8, 0.8), (32, 8, 0.8), (32, 32, 0.8), (8, 32, 0.8)], 25, 25)
    points = crack.points - np.maximum(crack.points[:, :1] - 25.0, 0.0) * (0, 0, 1)
    lengths = found(crack_from_triangles(points, crack.triangles, None, BOX))
    level = lengths.points[:, 0] < 24
    assert level.any() and np.allclose(lengths.lengths[level], PER_WIDTH * 0.8)
    assert lengths.points[:, 0].max() < 25.5  # where it goes down to the face it makes a wedge


@pytest.mark.parametrize("gap", [0.02, 0.1, 0.15])
def test_a_front_that_comes_near_a_face_has_edges_of_a_share_of_the_gap(gap):
    lengths = found(penny(10.0, degrees=90.0, centre=(12.0 + gap, 20.0)))
    wished = max(PER_WIDTH * gap, SHORTEST_BESIDE_LINES * L_MIN)
    assert wished <= lengths.at(np.array([[gap, 20.0, 10.0]]))[0] < wished + APART


@pytest.mark.parametrize("gap", [0.1, 0.3])
def test_a_mouth_beside_an_edge_of_the_box_has_edges_of_a_share_of_the_gap(gap):
    """A plane at 45 degrees to two faces that goes from its mouth on y = 0 to a front at y = 9."""
    lengths = found(plate([(gap - 1, -1, 8), (gap - 1, -1, 12), (gap + 9, 9, 12), (gap + 9, 9, 8)]))
    at = lengths.at(np.array([[gap, 0.0, z] for z in (9.0, 10.0, 11.0)]))
    assert (at >= PER_WIDTH * gap * (1 - 1e-9)).all() and (at < PER_WIDTH * gap + APART).all()


@pytest.mark.parametrize("gap", [0.02, 0.03])
def test_where_the_crack_goes_on_along_a_face_edges_are_a_larger_share_of_the_gap(gap):
    """A plane at under 20 degrees to the face x = 0 that leaves the gap at its mouth on y = 0."""
    flat = plate([(gap - 0.36, -1, 8), (gap - 0.36, -1, 12), (gap + 3.24, 9, 12), (gap + 3.24, 9, 8)])
    assert found(flat).lengths.min() == pytest.approx(PER_WIDTH_IN_WEDGE * gap, rel=1e-6)


def ridge(start: float, end: float, slope: float = 1.5) -> Crack:
    """Two limbs that come down from the top to a kink along y, from a depth under the top to another."""
    y = np.linspace(-5.0, 45.0, 11)
    line = np.stack([np.full(11, 20.0), y, 20 - start - (end - start) * y / 40], axis=1)
    places = np.stack([line + [side * 4, 0, abs(side) * 4 * slope] for side in (-1, 0, 1)])
    return Crack(*over_grid(*places.transpose(2, 0, 1)), ())


@pytest.mark.parametrize("slope", [0.5, 1.5])  # kinks of 53 and 113 degrees
@pytest.mark.parametrize("depth", [0.01, 0.05, 0.2])
def test_edges_along_a_kink_are_a_share_of_its_distance_from_a_face(depth, slope):
    lengths = found(ridge(depth, depth, slope))
    wished = max(PER_WIDTH * depth, SHORTEST_BESIDE_LINES * L_MIN)
    along = np.column_stack([np.full(50, 20.0), np.linspace(0.5, 39.5, 50), np.full(50, 20.0 - depth)])
    assert (lengths.at(along) >= wished * (1 - 1e-9)).all() and (lengths.at(along) < wished + APART).all()


def test_a_kink_that_goes_steeply_out_of_the_face_and_a_rough_crack_keep_their_lengths():
    assert len(kink_edges(ridge(-10.0, 10.0))) and found(ridge(-10.0, 10.0)) is None
    x, y = np.meshgrid(np.arange(10.0, 31), np.arange(10.0, 31), indexing="ij")
    rough = Crack(*over_grid(x, y, 12 - np.random.default_rng(0).uniform(0, 2, x.shape)), ())
    assert not len(kink_edges(rough)), "edges at all its kinks would be short everywhere"


@pytest.mark.parametrize("turn", [0.0, 30.0, 90.0])
@pytest.mark.parametrize("gap", [0.02, 0.05, 0.1])
def test_edges_are_short_between_a_front_and_another_sheet(gap, turn):
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    other = plate([(20 + gap + r * c, y, 10 + r * s) for r, y in ((0, 5), (6, 5), (6, 35), (0, 35))])
    both = one_crack([plate([(14, 5, 10), (20, 5, 10), (20, 35, 10), (14, 35, 10)]), other])
    lengths = found(both)
    at = lengths.at(np.array([[20 + gap / 2, y, 10.0] for y in np.arange(7.0, 33)]))
    length = PER_WIDTH_IN_WEDGE * gap
    assert (at >= length * (1 - 1e-9)).all() and (at < length + APART).all()
    assert (lengths.at(np.array([[14.0, 20.0, 10.0]])) > length + 2.5).all()


@pytest.mark.parametrize("height", [0.0, 5.0])
def test_sheets_that_meet_in_a_line_or_are_apart_keep_their_lengths(height):
    flat = plate([(10, 10, 10), (30, 10, 10), (30, 30, 10), (10, 30, 10)])
    upright = plate(
        [(20, 12, 10 + height), (20, 28, 10 + height), (20, 28, 19 - height), (20, 12, 19 - height)]
    )
    assert found(one_crack([flat, upright])) is None
