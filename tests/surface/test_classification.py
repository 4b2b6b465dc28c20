"""What vertices are free to do, against references that go vertex by vertex."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from test_patches import random_soup, slow_features, slow_patch

from craftmesh.surface.classification import Classification
from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.ranks import AT_JUNCTION, IN_PATCH, ON_LINE
from craftmesh.types import CRACK, INTERFACE, Surface


def groups_at(facets: list, v: int) -> int:
    """Return the number of groups that facets at a vertex fall into, joined over edges there."""
    groups: list[set] = []
    for corners in (set(facet) - {v} for facet in facets if v in facet):
        joined = [group for group in groups if group & corners]
        groups = [group for group in groups if not group & corners] + [corners.union(*joined)]
    return len(groups)


def slow_rank(surface: Surface, v: int) -> int:
    facets = surface.facets.tolist()
    met = []
    for edge in (edge for edge, feature in slow_features(surface).items() if feature and v in edge):
        at = [f for f, corners in enumerate(facets) if set(edge) <= set(corners)]
        met.append(sorted(slow_patch(surface, f) for f in at))
    if groups_at(facets, v) > 1 or (met and (len(met) != 2 or met[0] != met[1])):
        return AT_JUNCTION
    return ON_LINE if met else IN_PATCH


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(6, 40), st.sampled_from([6, 9, 40]))
def test_ranks_of_any_facets(seed, facets, points):
    surface = random_soup(seed, facets, points)
    rank = Classification(surface).rank
    assert rank.tolist() == [slow_rank(surface, v) for v in range(points)]


def test_ranks_of_a_fan_a_line_and_a_vertex_where_two_fans_touch():
    ring = [[0, 1 + k, 1 + (k + 1) % 4] for k in range(4)]
    other = [[0, 5 + k, 5 + (k + 1) % 4] for k in range(4)]
    points = np.zeros((9, 3))

    def rank_of_first(facets: list, sides: list) -> int:
        return int(Classification(Surface(points, facets, sides, [INTERFACE] * len(facets))).rank[0])

    assert rank_of_first(ring, [[1, 2]] * 4) == IN_PATCH
    assert rank_of_first(ring, [[1, 2], [2, 1], [3, 2], [3, 2]]) == ON_LINE
    assert rank_of_first(ring, [[1, 2], [1, 2], [3, 2], [4, 2]]) == AT_JUNCTION
    assert rank_of_first(ring + other, [[1, 2]] * 8) == AT_JUNCTION


def test_planes_and_crack_hold_the_coordinates_of_their_points():
    facets = [[0, 1, 2], [0, 1, 3], [2, 3, 4], [1, 5, 4]]
    surface = Surface(np.zeros((6, 3)), facets, [[1, 0], [1, 0], [1, 2], [1, 1]], [1, 4, INTERFACE, CRACK])
    classes = Classification(surface)
    held = [[True, True, False]] * 2 + [[True, False, False], [False, True, False]] + [[False] * 3] * 2
    assert classes.held.tolist() == held
    assert classes.planes.tolist() == [9, 9, 1, 8, 0, 0]
    assert classes.on_crack.tolist() == [False, True, False, False, True, True]
    assert classes.free.tolist() == [[not h and v not in (1, 4, 5) for h in held[v]] for v in range(6)]


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_the_front_is_where_its_edges_end(seed):
    surface = random_soup(seed)
    on_front = Classification(surface).on_front
    assert np.array_equal(np.flatnonzero(on_front), np.unique(front_edges(surface)))


def test_a_surface_without_facets_holds_nothing():
    nothing = Classification(Surface(np.zeros((2, 3)), np.zeros((0, 3)), np.zeros((0, 2)), np.zeros(0)))
    assert nothing.rank.tolist() == [IN_PATCH] * 2 and nothing.free.all() and not nothing.on_front.any()
