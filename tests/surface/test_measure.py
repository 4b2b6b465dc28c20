"""Measures of facets and extents by their definitions."""

import numpy as np
import pytest

from craftmesh.surface.measure import facet_angles, meets_box, side_volumes, volume_drift
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
