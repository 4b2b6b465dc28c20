"""Kinks as lines of a patch: points on them, joined, clear of what is there."""

import numpy as np
import pytest
import shapely

from craftmesh.insertion.creases import CLEAR, Creases, lay_kinks
from craftmesh.insertion.patch import loosen, refine, triangulate
from craftmesh.surface.connectivity import facet_edges

SIDE = 6.0
ON_KINK = 4  # the point of the trace that the kink passes through


def patch_with_a_trace():
    """A square with a trace from side to side, bent at a point on the kink."""
    uv = np.array([[0, 0], [SIDE, 0], [SIDE, SIDE], [0, SIDE], [3.0, 2.5], [0, 2.0], [SIDE, 2.0]])
    segments = np.array([[0, 1], [1, 6], [6, 2], [2, 3], [3, 5], [5, 0], [5, 4], [4, 6]])
    inside = shapely.box(0, 0, SIDE, SIDE)
    return triangulate(
        uv, segments, np.zeros(0, np.int64), lambda at: np.where(shapely.contains_xy(inside, *at.T), 1, -1)
    )


def kink(*places: tuple[float, float]) -> Creases:
    """A polyline as a crease; its places in space are not asked for."""
    ends = np.array([places[:-1], places[1:]], float).swapaxes(0, 1)
    return Creases(ends, np.zeros((len(ends), 2, 3)), shapely.STRtree(shapely.linestrings(ends)))


def even(size: float):
    return lambda uv: np.full(len(uv), size)


def edges_with_fixed(patch) -> dict[tuple[int, int], bool]:
    pairs = np.sort(facet_edges(patch.triangles), axis=1).tolist()
    return dict(zip(map(tuple, pairs), patch.fixed[: len(patch.triangles)].ravel().tolist()))


@pytest.mark.parametrize("size", [0.3, 0.5, 0.8])
def test_a_kink_gets_points_along_it_that_edges_join(size):
    patch, laid = lay_kinks(patch_with_a_trace(), kink((3, -1), (3, 4), (3, 7)), even(size), size)
    new = patch.uv[7 : patch.used[0]]
    assert (new[:, 0] == 3).all()
    trace = shapely.LineString([(0, 2), (3, 2.5), (6, 2)])
    assert shapely.distance(shapely.points(new), trace).min() > 0.999 * CLEAR * size
    assert (np.minimum(new[:, 1], SIDE - new[:, 1]) > CLEAR * size * 0.999).all()
    spans = np.diff(np.sort(np.append(new[:, 1], 2.5)))
    assert spans.max() < 1.5 * size
    assert spans.min() > 0.15 * size
    assert len(laid) == len(new)  # the trace's point is one more
    assert (laid == ON_KINK).sum() == 2
    known = edges_with_fixed(patch)
    assert all(known[tuple(sorted(pair))] for pair in laid.tolist())


def test_refining_keeps_the_kink_and_comes_near_it_on_neither_side():
    patch, laid = lay_kinks(patch_with_a_trace(), kink((3, -1), (3, 7)), even(0.5), 0.5)
    patch = refine(patch, even(0.5), np.zeros((0, 3), np.int64))
    known = edges_with_fixed(patch)
    assert all(known[tuple(sorted(pair))] for pair in laid.tolist())
    beside = np.abs(patch.uv[7 + len(laid) : patch.used[0], 0] - 3)
    assert beside[beside > 0].min() > 0.1
    before = patch.fixed.sum()
    loosen(patch, laid)
    assert before - patch.fixed.sum() == 2 * len(laid)


@pytest.mark.parametrize(
    "places", [((2, 4), (3, 4)), ((-3, -3), (-1, 5)), ((0.01, 2), (0.01, 6))], ids=["short", "out", "wall"]
)
def test_kinks_that_are_short_or_past_the_patch_or_along_a_wall_are_left_out(places):
    patch, laid = lay_kinks(patch_with_a_trace(), kink(*places), even(0.5), 0.5)
    assert not len(laid)
    assert patch.used[0] == 7


def test_a_kink_goes_through_a_corner_of_a_trace_that_is_almost_on_it():
    patch, laid = lay_kinks(patch_with_a_trace(), kink((-1, 2.51), (7, 2.51)), even(0.5), 0.5)
    assert (laid == ON_KINK).sum() == 2
    others = shapely.linestrings(patch.uv[laid[(laid != ON_KINK).all(axis=1)]])
    assert len(others) > 5
    assert shapely.distance(others, shapely.Point(3, 2.5)).min() > 0.05


def test_a_kink_is_joined_past_a_corner_that_is_off_it():
    patch, laid = lay_kinks(patch_with_a_trace(), kink((-1, 2.6), (7, 2.6)), even(0.5), 0.5)
    assert not (laid == ON_KINK).any()
    assert shapely.distance(shapely.linestrings(patch.uv[laid]), shapely.Point(3, 2.6)).min() < 1e-12


@pytest.mark.parametrize("corner", [(1, 3), (2.3, 3.1)])
def test_a_kink_that_closes_is_a_ring_of_points_once_each(corner):
    x, y = corner
    ring = ((x, y), (x + 2, y), (x + 2, y + 2), (x, y + 2), (x, y))
    patch, laid = lay_kinks(patch_with_a_trace(), kink(*ring), even(0.5), 0.5)
    new = patch.uv[7 : patch.used[0]]
    assert len(np.unique(new.round(9), axis=0)) == len(new) == len(laid)
    assert (np.bincount(laid.ravel())[7:] == 2).all()
