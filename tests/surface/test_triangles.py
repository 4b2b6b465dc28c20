"""Triangle intersection against a plain reference, and the search for pairs against all pairs."""

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from models import voronoi

from craftmesh.remeshing.kernels.marching import march
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.kernels.triangles import CONTACT, triangles_intersect

SMALL = st.integers(0, 4)


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def clip_polygon(polygon, normal, origin):
    """The part of a convex polygon (or segment, or point) with normal . (x - origin) >= 0, exactly."""
    kept = []
    for p, q in zip(polygon, polygon[1:] + polygon[:1]):
        hp, hq = dot(normal, minus(p, origin)), dot(normal, minus(q, origin))
        if hp >= 0:
            kept.append(p)
        if hp * hq < 0:
            t = hp / (hp - hq)
            kept.append([x + t * (y - x) for x, y in zip(p, q)])
    return kept


def common_points(a, b):
    """Corners of the convex set that two closed triangles have in common, in exact arithmetic."""
    normal = cross(minus(b[1], b[0]), minus(b[2], b[0]))
    common = clip_polygon(a, normal, b[0])
    common = clip_polygon(common, [-x for x in normal], b[0])
    for p, q in zip(b, b[1:] + b[:1]):
        common = clip_polygon(common, cross(normal, minus(q, p)), p)
    return {tuple(p) for p in common}


def intersect_slowly(points, a, b):
    """Whether two triangles meet in more than the span of the vertices they share."""
    exact = [[Fraction(float(x)) for x in p] for p in points]
    common = common_points([exact[i] for i in a], [exact[i] for i in b])
    shared = [exact[i] for i in a if i in b]
    if len(shared) == 2:
        edge = minus(shared[1], shared[0])
        return any(any(cross(edge, minus(list(p), shared[0]))) for p in common)
    return len(common - {tuple(p) for p in shared}) > 0


def is_flat(points, triangle):
    p = points[list(triangle)]
    return not np.cross(p[1] - p[0], p[2] - p[0]).any()


@settings(max_examples=200)
@given(st.lists(st.tuples(SMALL, SMALL, SMALL), min_size=6, max_size=6, unique=True), st.integers(0, 2))
def test_agrees_with_exact_clipping(points, shared):
    """Coordinates on a coarse grid make touching and coplanar pairs frequent."""
    points = np.array(points, float)
    a, b = [0, 1, 2], [*range(shared), *range(3, 6 - shared)]
    if is_flat(points, a) or is_flat(points, b):
        return
    assert triangles_intersect(points, *a, *b) == intersect_slowly(points, a, b)


@settings(max_examples=80)
@given(
    st.lists(st.tuples(SMALL, SMALL), min_size=6, max_size=6, unique=True),
    st.integers(0, 2),
    st.permutations(range(3)),
)
def test_agrees_in_a_plane_of_the_box_whatever_the_axis(points, shared, axes):
    points = np.column_stack([np.array(points, float), np.full(6, 0.3)])[:, list(axes)]
    a, b = [0, 1, 2], [*range(shared), *range(3, 6 - shared)]
    if is_flat(points, a) or is_flat(points, b):
        return
    assert triangles_intersect(points, *a, *b) == intersect_slowly(points, a, b)


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1), st.integers(0, 2))
def test_does_not_depend_on_order_or_placement(seed, shared):
    rng = np.random.default_rng(seed)
    points = rng.random((6, 3))
    a, b = np.array([0, 1, 2]), np.array([*range(shared), *range(3, 6 - shared)])
    expected = triangles_intersect(points, *a, *b)
    turned = points @ np.linalg.qr(rng.normal(size=(3, 3)))[0] * 7 + 100
    for x, y in ((a, b), (b, a), (a[[1, 2, 0]], b[::-1]), (a[::-1], b[[2, 0, 1]])):
        assert triangles_intersect(points, *x, *y) == expected
        assert triangles_intersect(turned, *x, *y) == expected


def test_a_fold_on_a_plane_of_the_box_is_found():
    points = np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1], [0.4, 0.3, 1]], float)
    assert not triangles_intersect(points, 0, 1, 2, 1, 3, 2)
    assert triangles_intersect(points, 0, 1, 2, 1, 4, 2)
    assert triangles_intersect(points, 0, 1, 2, 2, 1, 0)


def test_needles_beside_large_triangles():
    """A flat triangle has no plane of its own, yet its edges still pierce the other one."""
    points = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1], [1, 1, 0.5]], float)
    assert triangles_intersect(points, 0, 1, 2, 3, 4, 5)
    assert triangles_intersect(points, 3, 4, 5, 0, 1, 2)
    points[3:, 0] += 9
    assert not triangles_intersect(points, 0, 1, 2, 3, 4, 5)


def random_soup(seed, count):
    """Triangles with sizes from 0.05 to 1.6, a few of which share vertices."""
    rng = np.random.default_rng(seed)
    size = 0.05 * 2.0 ** rng.integers(0, 6, (count, 1, 1))
    points = (rng.random((count, 1, 3)) * 3 + rng.random((count, 3, 3)) * size).reshape(-1, 3)
    facets = np.arange(3 * count).reshape(-1, 3)
    facets[1::5, 0] = facets[0::5, 0][: len(facets[1::5])]
    return points, facets


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_the_grid_finds_what_all_pairs_find(seed):
    points, facets = random_soup(seed, 60)
    expected = [
        (f, g)
        for f, g in combinations(range(len(facets)), 2)
        if triangles_intersect(points, *facets[f], *facets[g])
    ]
    assert intersecting_pairs(points, facets).tolist() == [list(pair) for pair in expected]


@settings(max_examples=12)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.05, 0.3, 0.6, 1.0]))
def test_surfaces_with_stars_of_any_kind_are_searched_as_all_pairs(seed, size):
    """Points go astray: little enough for even stars, or so far that facets fold and cross."""
    rng = np.random.default_rng(seed)
    points, facets, _, _ = march(voronoi(seed % 1000, 3, (4, 4, 4)).labels)
    points = points + size * rng.random((len(points), 1)) ** 4 * rng.normal(size=points.shape)
    expected = [
        [f, g]
        for f, g in combinations(range(len(facets)), 2)
        if triangles_intersect(points, *facets[f], *facets[g])
    ]
    assert intersecting_pairs(points, facets).tolist() == expected
    chosen = rng.random(len(facets)) < 0.1
    with_chosen = [pair for pair in expected if chosen[pair].any()]
    assert intersecting_pairs(points, facets, chosen=chosen).tolist() == with_chosen


def test_limit_and_empty_input():
    points, facets = random_soup(3, 300)
    found = intersecting_pairs(points, facets)
    assert len(found) > 10
    some = intersecting_pairs(points, facets, limit=5)
    assert len(some) == 5 and {tuple(p) for p in some} <= {tuple(p) for p in found}
    assert intersecting_pairs(points, facets[:0]).shape == (0, 2)


@pytest.mark.parametrize("power", [-30, 0, 30])
def test_triangles_touch_within_a_share_of_their_size_in_any_unit(power):
    size = 2.0**power
    facets = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 0], [2, 1, 0], [1, 2, 0]])
    for off, meet in ((0.5, True), (2.0, False)):
        for up in (-1, 1):
            points = facets.copy()
            points[3:, 2] = up * off * CONTACT * 4 * np.sqrt(2)  # of a size of 4 to 4 root 2
            assert triangles_intersect(size * points, 0, 1, 2, 3, 4, 5) == meet
            # turned so that a corner alone is near, and the other corners far above
            points[4:, 2] = up * 3
            assert triangles_intersect(size * points, 0, 1, 2, 3, 4, 5) == meet
