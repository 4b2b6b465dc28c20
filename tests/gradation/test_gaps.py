"""Edges are short in gaps between the front of a crack and another crack or a face, and nowhere else."""

import numpy as np
import pytest
from few_facets import sheet
from given_cracks import over_grid

from craftmesh.gradation.gaps import LEAST, PER_GAP, short_in_gaps
from craftmesh.sizing.sizing import FREE_GROWTH, Sizing
from craftmesh.types import CRACK, INTERFACE, Surface

N = 6


def squares(*moves: np.ndarray) -> Surface:
    """Crack sheets of one grain, each a square of N by N edges at z = 0 moved by a function of points."""
    x, y = np.meshgrid(np.arange(N + 1.0), np.arange(N + 1.0), indexing="ij")
    flat, facets = over_grid(x, y, np.zeros_like(x))
    points = np.concatenate([move(flat) for move in moves])
    shifted = [facets + number * len(flat) for number in range(len(moves))]
    return sheet(np.concatenate(shifted), (1, 1), CRACK, points)


def stay(points: np.ndarray) -> np.ndarray:
    return points


def beside(gap: float, turn: float = 0.0):
    """Move a square by its edge and a gap along x, and turn it about the line of its near edge."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    return lambda p: np.stack([N + gap + c * p[:, 0], p[:, 1], s * p[:, 0]], axis=1)


def in_a_box(crack: Surface) -> Surface:
    """Return a crack with a facet of a boundary far off: the box reaches from x = 0 on around it."""
    corners = np.array([[0.0, -20, -20], [20, 30, -20], [20, 30, 20]])
    facets = np.concatenate([crack.facets, len(crack.points) + np.arange(3)[None]])
    sides, kind = np.concatenate([crack.sides, [[1, 2]]]), np.concatenate([crack.kind, [INTERFACE]])
    return sheet(facets, sides, kind, np.concatenate([crack.points, corners]))


def uniform(l_min: float = 1.0) -> Sizing:
    return Sizing(l_min, 10.0, 10.0, 0.0, 0.0, 1.0, np.zeros((0, 3)))


@pytest.mark.parametrize("turn", [0.0, 30.0, 90.0])
@pytest.mark.parametrize("gap", [0.2, 0.03, 0.001])
def test_edges_are_short_in_a_gap_and_grow_away_from_it(gap, turn):
    found = short_in_gaps(squares(stay, beside(gap, turn)), uniform())
    inner = np.array([[N + gap / 2, y, 0.0] for y in np.arange(1.0, N)])
    length = max(PER_GAP * gap, LEAST)
    # places are up to an edge apart, and lengths grow by half the distance
    assert (found.at(inner) >= length).all() and (
        found.at(inner) <= length + FREE_GROWTH * gap + 1e-9
    ).all()
    assert (found.at(inner - [4.0, 0, 0]) > length + 3.5 * FREE_GROWTH).all()


def test_lengths_stay_where_the_gap_is_wide_or_there_is_one_crack():
    for moves in [(stay,), (stay, beside(1.01 / PER_GAP)), (stay, lambda p: p + [0, 0, 0.5])]:
        sizing = uniform()
        assert short_in_gaps(squares(*moves), sizing) is sizing


def test_a_front_that_comes_near_another_crack_at_a_point_alone_has_its_lengths():
    sizing = uniform()
    upright = squares(
        stay, lambda p: np.stack([3 + 0 * p[:, 0], p[:, 1], 0.05 + p[:, 0] + p[:, 1]], axis=1)
    )
    assert short_in_gaps(upright, sizing) is sizing


def test_a_crack_that_meets_another_in_a_line_has_its_lengths():
    """A sheet that ends on another shares its points there; where they part the front is steep to it."""
    both = squares(stay, lambda p: np.stack([3 + 0 * p[:, 0], p[:, 1], p[:, 0]], axis=1))
    same = {tuple(point): row for row, point in reversed(list(enumerate(both.points.tolist())))}
    new = np.array([same[tuple(point)] for point in both.points.tolist()])
    sizing = uniform()
    joined = Surface(both.points, new[both.facets], both.sides, both.kind)
    assert short_in_gaps(joined, sizing) is sizing


@pytest.mark.parametrize("turn", [0.0, 30.0, 60.0])
@pytest.mark.parametrize("gap", [0.2, 0.03])
def test_edges_are_short_between_a_front_and_a_face_of_the_box(gap, turn):
    surface = in_a_box(squares(lambda p: beside(gap, turn)(p) - [N, 0, 0]))
    found = short_in_gaps(surface, uniform())
    inner = np.array([[gap / 2, y, 0.0] for y in np.arange(1.0, N)])
    assert (found.at(inner) >= PER_GAP * gap).all()
    assert (found.at(inner) <= (PER_GAP + FREE_GROWTH) * gap + 1e-9).all()
    assert (found.at(inner + [4.0, 0, 0]) > PER_GAP * gap + 3.5 * FREE_GROWTH).all()


@pytest.mark.parametrize("shift, slope", [(0.0, 0.0), (1.01 / PER_GAP, 0.0), (0.0, 0.3)])
def test_a_front_on_a_face_far_from_it_or_that_runs_down_to_it_steeply_has_its_lengths(shift, slope):
    def move(points: np.ndarray) -> np.ndarray:
        return points + np.outer(shift + slope * points[:, 1], [1.0, 0, 0])

    sizing = uniform()
    assert short_in_gaps(in_a_box(squares(move)), sizing) is sizing
