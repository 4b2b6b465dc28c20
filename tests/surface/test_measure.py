"""Measures of facets and extents by their definitions."""

import numpy as np
import pytest
from few_facets import facet_shapes

from craftmesh.surface.measure import (
    area_vectors,
    facet_angles,
    meets_box,
    side_volumes,
    swept_volumes,
    volume_drift,
)
from craftmesh.surface.side_data import UNITS, are_apart, unit_hint

METRES = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}


def test_bounds_meet_a_box_where_they_overlap_along_each_axis():
    rng = np.random.default_rng(4)
    box = np.array([[0.0, 1.0, -2.0], [3.0, 2.0, 2.0]])
    corners = rng.uniform(-3, 4, (2000, 1, 3)) + rng.uniform(-1, 1, (2000, 3, 3))
    corners[0] = [[3, 2, 2], [4, 2, 2], [3, 3, 2]]  # it touches a corner
    overlap = np.minimum(corners.max(axis=1), box[1]) - np.maximum(corners.min(axis=1), box[0])
    assert (meets_box(corners, box) == (overlap >= 0).all(axis=1)).all()
    assert 0.02 < meets_box(corners, box).mean() < 0.5 and meets_box(corners, box)[0]


@pytest.mark.parametrize("power", UNITS)
def test_a_hint_names_units_whose_numbers_are_that_far_apart(power):
    fine, coarse = UNITS[power]
    assert METRES[coarse] / METRES[fine] == pytest.approx(10.0**power)
    span = np.array([[1.0, 2.0, 3.0], [4.0, 6.0, 9.0]])
    for factor, said in (
        (10.0**power, f"large ({fine} beside {coarse}?)"),
        (10.0**-power, f"small ({coarse}"),
    ):
        assert said in unit_hint(factor * span, span) and f"about {10**power} times" in unit_hint(
            factor * span, span
        )
    assert unit_hint(span, span) == unit_hint(10.0**power * span + 1e10, span) == ""


def test_spans_are_apart_beyond_a_gap_along_any_axis():
    first = np.array([[0.0, 0, 0], [1, 1, 1]])
    for axis in range(3):
        for way in (-1, 1):
            other = first + 1.5 * way * np.eye(3)[axis]
            assert (
                are_apart(first, other)
                and are_apart(first, other, 0.4)
                and not are_apart(first, other, 0.6)
            )
    assert not are_apart(first, first + [1, -1, 1])


def test_angles_volumes_and_drifts_of_a_known_body():
    points = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0], [0, 0, 5]]) + 100
    facets = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert side_volumes(points, facets, np.tile([2, 0], (4, 1))) == {2: pytest.approx(10)}
    sides = np.array([[2, 0], [2, 5], [2, 0], [2, 2]])  # a facet with one label on both sides adds nothing
    assert set(side_volumes(points, facets, sides)) == {2, 5}
    turned = np.degrees(np.arctan2([4, 3], [3, 4]))
    assert facet_angles(points, facets[:1])[0] == pytest.approx([90, turned[1], turned[0]])
    assert volume_drift({1: 2.0, 2: 4.0, 3: 0.0}, {1: 3.0, 3: 1.0}) == {1: 0.5, 2: -1, 3: 0}


def test_measures_of_all_facets_are_those_by_their_definitions():
    rng = np.random.default_rng(7)
    points, facets = rng.normal(size=(30, 3)), rng.integers(0, 30, (200, 3))
    facets[0] = 4  # all corners in one point
    a, b, c = np.moveaxis(points[facets], 1, 0)
    normals = np.cross(b - a, c - a) / 2
    squares = np.stack([((u - v) ** 2).sum(axis=1) for u, v in ((a, b), (b, c), (c, a))])
    # what rounding makes of sums of a few products of numbers of about 1
    assert np.allclose(area_vectors(points, facets), normals, atol=1e-14)
    quality, shortest = facet_shapes(points, facets)
    area = np.linalg.norm(normals, axis=1)
    expected = 4 * np.sqrt(3) * area / np.where(squares.sum(axis=0) > 0, squares.sum(axis=0), 1)
    assert np.allclose(quality, expected, atol=1e-14)
    assert np.allclose(shortest, np.sqrt(squares.min(axis=0)), atol=1e-14)
    middle = points.mean(axis=0)
    swept = [np.linalg.det(np.stack(corners) - middle) / 6 for corners in zip(a, b, c)]
    assert np.allclose(swept_volumes(points, facets), swept, atol=1e-13)
