"""The crack's front and its ears: one crack facet on the edge, nothing free, whatever else meets there."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.surface.front import ears, front_edges, front_of
from craftmesh.types import CRACK, INTERFACE, Surface


def edges_of(facet) -> list[tuple[int, int]]:
    return [tuple(sorted((int(facet[i]), int(facet[(i + 1) % 3])))) for i in range(3)]


def slow_front(surface: Surface) -> list[tuple[int, int]]:
    """Edges that exactly one crack facet has, and no facet of the exterior or a void."""
    crack, free = [], set()
    for facet, sides, kind in zip(surface.facets, surface.sides, surface.kind):
        if kind == CRACK:
            crack += edges_of(facet)
        if sides.min() <= 0:
            free |= set(edges_of(facet))
    return sorted(edge for edge in set(crack) if crack.count(edge) == 1 and edge not in free)


def slow_ears(crack, on_front) -> list[tuple[int, int]]:
    met = [edge for facet in crack for edge in edges_of(facet)]
    return sorted(e for e in set(met) if met.count(e) > 1 and on_front[e[0]] and on_front[e[1]])


def random_soup(seed: int) -> Surface:
    rng = np.random.default_rng(seed)
    count, points = int(rng.integers(1, 50)), 11
    facets = np.array([rng.choice(points, 3, replace=False) for _ in range(count)])
    kind = rng.choice([INTERFACE, 3, CRACK, CRACK], count)
    sides = rng.integers(1, 4, (count, 2))
    sides[kind == 3, 0] = 0
    sides[(kind == INTERFACE) & (rng.random(count) < 0.3), 1] = -1
    return Surface(rng.normal(size=(points, 3)), facets, sides, kind)


@settings(max_examples=80)
@given(st.integers(0, 2**32 - 1))
def test_fronts_and_ears_are_those_found_edge_by_edge(seed):
    surface = random_soup(seed)
    found = front_edges(surface)
    assert list(map(tuple, found.tolist())) == slow_front(surface)
    on_front = np.zeros(len(surface.points), bool)
    on_front[found] = True
    crack = surface.facets[surface.kind == CRACK]
    assert list(map(tuple, ears(crack, on_front).tolist())) == slow_ears(crack, on_front)


def square_crack(more_facets=(), more_sides=(), more_kinds=()) -> Surface:
    """The crack of two facets 0 1 2, 0 2 3, and whatever else; points 4, 5 lie beside its edge 0 1."""
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, -1, 0], [0.5, -1, 1]]
    return Surface(
        points,
        [[0, 1, 2], [0, 2, 3], *more_facets],
        [[1, 1], [1, 1], *more_sides],
        [CRACK, CRACK, *more_kinds],
    )


RIM = [[0, 1], [0, 3], [1, 2], [2, 3]]


def test_a_crack_inside_a_grain_ends_in_its_front_all_round():
    assert front_edges(square_crack()).tolist() == RIM


@pytest.mark.parametrize("facets", [[[0, 1, 4]], [[0, 1, 4], [1, 0, 5]]])
def test_a_front_along_a_grain_boundary_is_front(facets):
    surface = square_crack(facets, [[1, 2]] * len(facets), [INTERFACE] * len(facets))
    assert front_edges(surface).tolist() == RIM


@pytest.mark.parametrize("sides, kind", [([1, 0], 3), ([1, 0], INTERFACE), ([-2, 1], INTERFACE)])
def test_the_mouth_on_the_box_on_the_exterior_or_on_a_void_is_no_front(sides, kind):
    surface = square_crack([[0, 1, 4], [1, 0, 5]], [sides] * 2, [kind] * 2)
    assert front_edges(surface).tolist() == RIM[1:]


def test_an_edge_inside_the_crack_between_front_points_is_an_ear():
    crack = square_crack().facets
    assert ears(crack, np.ones(6, bool)).tolist() == [[0, 2]]
    assert ears(crack, np.array([False, True, True, True, False, False])).tolist() == []


def test_without_crack_there_is_no_front():
    nothing = np.zeros((0, 3), np.int64)
    assert front_of(nothing, np.array([[0, 1, 2]])).shape == (0, 2)
    assert ears(nothing, np.zeros(0, bool)).shape == (0, 2)
