"""Patches, feature edges and box planes, against references that go facet by facet."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.surface.patches import (
    PLANES,
    box_axis,
    feature_edges,
    is_on_box,
    oriented,
    patches,
)
from craftmesh.types import BOX_PLANES, CRACK, INTERFACE, Surface


def random_soup(seed: int, facets: int = 60, points: int = 12) -> Surface:
    """Facets between few points, with runs of like sides and kinds, so that edges meet in every way."""
    rng = np.random.default_rng(seed)
    corners = np.array([rng.choice(points, 3, replace=False) for _ in range(facets)])
    run = rng.integers(1, 6)
    sides = np.repeat(rng.integers(-2, 4, (facets, 2)), run, axis=0)[:facets]
    kind = np.repeat(rng.choice([INTERFACE, 1, 4, CRACK], facets), run)[:facets]
    return Surface(rng.normal(size=(points, 3)), corners, sides, kind)


def slow_patch(surface: Surface, f: int) -> tuple:
    """What tells the patch of a facet: larger label, smaller label and kind; on the crack lip by lip."""
    a, b = surface.sides[f].tolist()
    kind = int(surface.kind[f])
    return (a, b, kind) if kind == CRACK else (max(a, b), min(a, b), kind)


def slow_features(surface: Surface) -> dict[tuple, bool]:
    """Each edge, and whether other than two facets of one patch meet there."""
    met: dict[tuple, list] = {}
    for f, corners in enumerate(surface.facets.tolist()):
        for i in range(3):
            edge = tuple(sorted((corners[i], corners[(i + 1) % 3])))
            met.setdefault(edge, []).append(slow_patch(surface, f))
    return {edge: len(found) != 2 or found[0] != found[1] for edge, found in met.items()}


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_patches_are_numbered_by_labels_and_kind(seed):
    surface = random_soup(seed)
    names = [slow_patch(surface, f) for f in range(len(surface.facets))]
    order = sorted(set(names))
    found = patches(surface)
    assert found.of_facet.tolist() == [order.index(name) for name in names]
    assert found.first_facet.tolist() == [names.index(name) for name in order]


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_feature_edges_are_where_patches_meet(seed):
    surface = random_soup(seed)
    features = feature_edges(surface)
    assert dict(zip(map(tuple, features.edges.tolist()), features.is_feature.tolist())) == slow_features(
        surface
    )
    assert np.array_equal(features.lines, features.edges[features.is_feature])
    ends = np.stack([surface.facets, np.roll(surface.facets, -1, axis=1)], axis=2)
    assert np.array_equal(features.edges[features.of_corner], np.sort(ends, axis=2))
    assert np.array_equal(features.facets_on, np.bincount(features.of_corner.ravel()))
    known = feature_edges(surface, patches(surface).of_facet)
    assert all(np.array_equal(a, b) for a, b in zip(features, known))


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_orienting_keeps_facets_between_their_labels(seed):
    surface = random_soup(seed)
    facets, sides = oriented(surface)
    for f in range(len(facets)):
        a, b = surface.sides[f].tolist()
        turned = a < b and surface.kind[f] != CRACK
        assert sides[f].tolist() == ([b, a] if turned else [a, b])
        given_corners = surface.facets[f].tolist()
        assert facets[f].tolist() == (given_corners[::-1] if turned else given_corners)
    again = oriented(Surface(surface.points, facets, sides, surface.kind))
    assert np.array_equal(again[0], facets) and np.array_equal(again[1], sides)


def test_the_planes_of_the_box_by_kind():
    kind = np.arange(8, dtype=np.uint8)
    assert is_on_box(kind).tolist() == [False] + [True] * 6 + [False]
    assert box_axis(kind).tolist() == [-1, 0, 0, 1, 1, 2, 2, -1]
    for (plane, axis, upper), name in zip(PLANES, BOX_PLANES, strict=True):
        assert box_axis(np.array([plane])) == [axis]
        assert name == "XYZ"[axis] + ("MAX" if upper else "MIN")


@pytest.mark.parametrize("ask", [patches, feature_edges, oriented])
def test_a_surface_without_facets_has_none(ask):
    nothing = Surface(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 2)), np.zeros(0))
    assert all(len(part) == 0 for part in ask(nothing))
