"""Moves of a surface's points: what is wished is done, but for what would break a bound."""

import numpy as np
import pytest
from few_facets import facet_shapes, fan
from hypothesis import example, given, settings
from hypothesis import strategies as st
from structured_box import structured_box

from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.guarded_move import SETTLING, MoveBounds, guarded_move
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.spoiled import spoiled
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, edge_lengths
from craftmesh.surface.patches import PLANES
from craftmesh.surface.wedges import sharp_wedges
from craftmesh.types import Surface

BOX = structured_box((4, 4, 4), lambda centres: np.where(centres[:, 0] < 2, 1, 2))[0]


def turns(surface: Surface, points: np.ndarray) -> np.ndarray:
    """Return the degrees (m,) by which facets turn when they go to the points."""
    before, after = (area_vectors(at, surface.facets) for at in (surface.points, points))
    size = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", before, after) / size, -1, 1)))


@settings(max_examples=15)
@given(
    st.integers(0, 2**32 - 1), st.sampled_from([0.1, 0.5, 2.0]), st.sampled_from([MoveBounds(), SETTLING])
)
@example(
    1, 2.0, SETTLING
)  # a facet goes back last, and a neighbour that has stayed moved is sharp against it
def test_no_bound_is_broken_and_who_is_not_held_is_where_it_is_wished(seed, size, bounds):
    rng = np.random.default_rng(seed)
    wished = BOX.points + size * rng.normal(size=BOX.points.shape)
    points, held = guarded_move(BOX, wished, bounds)
    assert np.array_equal(points, np.where(held[:, None], BOX.points, wished))
    assert turns(BOX, points).max() <= bounds.turn + 1e-6
    least = np.minimum(bounds.quality, facet_shapes(BOX.points, BOX.facets)[0])
    assert (facet_shapes(points, BOX.facets)[0] >= least * (1 - 1e-12)).all()
    assert len(intersecting_pairs(points, BOX.facets)) == 0
    assert len(sharp_wedges(Surface(points, BOX.facets, BOX.sides, BOX.kind)).angle) == 0
    for plane, axis, upper in PLANES:
        level = BOX.points[BOX.facets[BOX.kind == plane][0, 0], axis]
        within = points[np.unique(BOX.facets), axis]
        assert (within <= level if upper else within >= level).all()


def test_a_sound_move_is_made_whole_and_the_surface_stays_sound():
    inner = ((BOX.points > 0) & (BOX.points < 4)).all(axis=1)
    wished = BOX.points + np.where(inner[:, None], [0.2, 0.1, 0.0], 0.0)
    points, held = guarded_move(BOX, wished, MoveBounds())
    assert inner.sum() == 9 and not held.any() and np.array_equal(points, wished)
    assert check_surface(Surface(points, BOX.facets, BOX.sides, BOX.kind)) == []


def test_of_a_bad_facet_the_farthest_point_is_held_alone():
    surface = fan(6)
    wished = surface.points.copy()
    wished[0] += [0.0, 0.0, 3.0]
    wished[1] += [0.0, 0.0, 0.1]
    points, held = guarded_move(surface, wished, MoveBounds())
    assert held.tolist() == [True] + [False] * (len(held) - 1)
    assert np.array_equal(points[1], wished[1])


@pytest.mark.parametrize("quality, edge, expected", [(0.05, 0.0, [True, False]), (0.0, 0.4, [False, True])])
def test_spoiled_facets_are_those_that_got_worse(quality, edge, expected):
    """The first facet becomes flat, the second small; a third is as flat and as small before."""
    before = np.array(
        [[0, 0, 0], [1, 0, 0], [0.5, 0.9, 0]] * 2 + [[0, 0, 0], [0.1, 0, 0], [0.05, 0.001, 0]]
    )
    before[3:, 2], before[6:, 2] = 5, 9
    after = before.copy()
    after[2, 1] = 0.02
    after[3:6, :2] *= 0.3
    facets = np.arange(9).reshape(3, 3)
    levels = np.array([[-np.inf] * 3, [np.inf] * 3])
    changed = np.ones(3, bool)
    lists, bounds = corner_lists(facets, 9), (180.0, quality, edge)
    assert spoiled(before, after, facets, lists, changed, levels, bounds).tolist() == [*expected, False]
    assert not spoiled(before, after, facets, lists, ~changed, levels, bounds).any()


def test_edges_stay_as_long_as_they_have_to_be():
    surface = fan(6)
    wished = surface.points.copy()
    wished[0] += 0.5 * (surface.points[1] - surface.points[0])
    edges = np.array([[0, 1]])
    length = edge_lengths(wished, edges)[0]
    for least, is_held in ((0.9 * length, False), (1.1 * length, True)):
        held = guarded_move(surface, wished, MoveBounds(180.0, 0.0, least))[1]
        assert held[0] == is_held


def test_what_a_function_wishes_follows_who_is_held_and_what_it_is_told_of_goes_back():
    asked = []

    def wished(held: np.ndarray) -> np.ndarray:
        asked.append(held.copy())
        return BOX.points + np.where(held[:, None], 0.0, [0.0, 0.0, 1e-3]) * (BOX.points[:, 2:] % 4 > 0)

    def spoils(points: np.ndarray) -> np.ndarray:
        return (points[BOX.facets[:, 0]] != BOX.points[BOX.facets[:, 0]]).any(axis=1) & (BOX.kind == 1)

    points, held = guarded_move(BOX, wished, MoveBounds(), spoils)
    on_plane = np.unique(BOX.facets[BOX.kind == 1])
    assert held[on_plane].all() and not held.all() and len(asked) > 1
    assert np.array_equal(points, wished(held))


@pytest.mark.parametrize("known", [None, np.zeros((0, 2), np.int64)])
def test_facets_that_intersect_already_may_stay_so_unless_they_are_said_to_be_none(known):
    crossing = Surface(
        np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0.5, 0.5, -1], [0.5, 0.5, 1], [3.0, 3, 0]]),
        np.array([[0, 1, 2], [3, 5, 4]]),
        [[1, 2]] * 2,
        [0] * 2,
    )
    wished = crossing.points.copy()
    wished[5, 0] += 0.1
    held = guarded_move(crossing, wished, MoveBounds(), known=known)[1]
    assert held[5] == (known is not None)
