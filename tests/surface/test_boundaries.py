"""Open edges and shells of grains, against plain counting."""

from collections import Counter
from itertools import combinations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.surface.connectivity import joined, open_edges
from craftmesh.surface.kernels.boundaries import close_pairs, outer_shells

POINTS = 5  # so few that edges often are alike
FACETS = st.lists(st.permutations(range(POINTS)).map(lambda row: row[:3]), min_size=1, max_size=40)


def array(facets):
    return np.array(facets, np.int64).reshape(-1, 3)


@given(FACETS, st.randoms(use_true_random=False))
def test_edges_are_open_where_a_label_has_them_more_often_one_way(facets, random):
    sides = [(random.choice((-1, 0, 2, 2**31 - 1)), random.choice((0, 2))) for _ in facets]
    balance: Counter = Counter()
    for row, (behind, ahead) in zip(facets, sides):
        for a, b in zip(row, row[1:] + row[:1]):
            way = 1 if a < b else -1
            balance[behind, min(a, b), max(a, b)] += way
            balance[ahead, min(a, b), max(a, b)] -= way
    expected = sorted(list(edge) for edge, times in balance.items() if times and edge[0])
    assert open_edges(array(facets), np.array(sides), POINTS).tolist() == expected


@given(st.lists(FACETS, min_size=1, max_size=4), st.randoms(use_true_random=False))
def test_shells_of_a_grain_are_those_that_points_join(grains, random):
    start = np.cumsum([0, *map(len, grains)])
    swept = np.array([random.uniform(-1, 1) for _ in range(start[-1])])
    expected = []
    for own, begin in zip(map(array, grains), start):
        shell = joined(POINTS, own[:, [0, 0]].ravel(), own[:, 1:].ravel())[own[:, 0]]
        volumes = np.bincount(shell, swept[begin : begin + len(own)])
        expected.append(int((volumes > 0).sum()))
    facets = array([row for own in grains for row in own])
    assert outer_shells(facets, start, swept, POINTS).tolist() == expected


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-6, 0.02, 0.2]))
def test_close_pairs_are_those_of_all_pairs(seed, reach):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(60, 3))
    points[30:] = points[:30] + reach * rng.normal(size=(30, 3))
    expected = {
        (p, q) for p, q in combinations(range(60), 2) if ((points[p] - points[q]) ** 2).sum() <= reach**2
    }
    found = close_pairs(points, reach, max(4 * reach, 1e-12))
    assert {(min(pair), max(pair)) for pair in found.tolist()} == expected
    assert len(expected) >= 30 * (reach == 0)  # every point and its copy
