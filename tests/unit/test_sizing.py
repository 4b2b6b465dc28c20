"""The sizing function: Eq. 2-3, its limits, its errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.sizing import Sizing, SizingOptions, densify, sizing_for
from craftmesh.types import Surface

ORIGIN = np.zeros((1, 3))


def at_radius(sizing, r):
    return sizing.at(np.array([[r, 0.0, 0.0]]))[0]


def test_equation_3_at_its_marks():
    sizing = Sizing(0.5, 1.0, 3.0, 8.0, 16.0, 2.0, ORIGIN)
    expected = {0.0: 0.5, 4.0: 0.5 + 0.5 * 0.25, 8.0: 1.0, 12.0: 2.0, 16.0: 3.0, 500.0: 3.0}
    for r, length in expected.items():
        assert at_radius(sizing, r) == pytest.approx(length, rel=1e-12)


def test_nearest_source_counts():
    sources = np.array([[0.0, 0, 0], [10.0, 0, 0]])
    sizing = Sizing(1.0, 2.0, 4.0, 4.0, 8.0, 1.0, sources)
    points = np.random.default_rng(1).uniform(-5, 15, (200, 3))
    slow = [sizing.at_distance(min(np.linalg.norm(p - s) for s in sources)) for p in points]
    assert np.allclose(sizing.at(points), np.array(slow), rtol=1e-12)


def test_no_sources_is_uniform():
    assert (Sizing(0.5, 1.0, 3.0, 8.0, 16.0, 1.0, np.zeros((0, 3))).at(np.ones((4, 3))) == 3.0).all()


def test_radii_may_be_equal_or_zero():
    step = Sizing(0.5, 1.0, 3.0, 2.0, 2.0, 1.0, ORIGIN)
    assert at_radius(step, 2.0) == 1.0 and at_radius(step, 2.1) == 3.0
    point = Sizing(0.5, 1.0, 3.0, 0.0, 0.0, 1.0, ORIGIN)
    assert at_radius(point, 0.0) == 0.5 and at_radius(point, 0.1) == 3.0


@settings(deadline=None, max_examples=50)
@given(
    st.floats(0.1, 1), st.floats(0, 2), st.floats(0, 3), st.floats(0, 9), st.floats(0, 9), st.floats(0.2, 4)
)
def test_lengths_stay_between_bounds_and_grow(l_min, more, most, r0, width, exponent):
    sizing = Sizing(l_min, l_min + more, l_min + more + most, r0, r0 + width, exponent, ORIGIN)
    lengths = sizing.at_distance(np.linspace(0, 25, 101))
    assert (lengths >= l_min * (1 - 1e-12)).all() and (lengths <= sizing.l_max * (1 + 1e-12)).all()
    assert (np.diff(lengths) >= -1e-12).all()


@pytest.mark.parametrize(
    ("key", "changes"),
    [
        ("r1", {"r1": 4.0}),
        ("l_min", {"l_min": 9.0}),
        ("l_min", {"l_min": 0.0}),
        ("l_min", {"l_min": -1.0}),
        ("exponent", {"exponent": 0.0}),
        ("l_max", {"l_max": float("nan")}),
        ("sources", {"sources": np.array([[0, 0, np.nan]])}),
    ],
)
def test_errors_name_the_key_in_one_line(key, changes):
    good = {
        "l_min": 0.5,
        "l0": 1.0,
        "l_max": 3.0,
        "r0": 8.0,
        "r1": 16.0,
        "exponent": 1.0,
        "sources": ORIGIN,
    }
    with pytest.raises(CraftmeshError, match=f"^{key}") as error:
        Sizing(**(good | changes))
    assert "\n" not in str(error.value)


def test_options_refuse_bad_numbers_at_once():
    with pytest.raises(CraftmeshError, match="^exponent"):
        SizingOptions(exponent=-1.0)


def test_defaults_follow_the_median_edge():
    points = np.array([[0.0, 0, 0], [2.0, 0, 0], [0, 2.0, 0], [2.0, 2.0, 0]])
    surface = Surface(points, [[0, 1, 2], [1, 3, 2]], [[1, 0], [1, 0]], [0, 0])
    sizing = sizing_for(surface, SizingOptions(), ORIGIN)
    assert (sizing.l_min, sizing.l0, sizing.l_max, sizing.r0, sizing.r1) == (1.0, 2.0, 6.0, 16.0, 32.0)
    assert sizing_for(surface, SizingOptions(r0=3.0), ORIGIN).r1 == 6.0
    assert sizing_for(surface, SizingOptions(l0=1.0), ORIGIN).l_max == 3.0


def test_densify_keeps_points_and_bounds_steps():
    line = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 2.5, 0], [1.0, 2.5, 0.01]])
    dense = densify(line, 0.3)
    assert np.linalg.norm(np.diff(dense, axis=0), axis=1).max() <= 0.3 + 1e-12
    assert all((dense == p).all(1).any() for p in line)
    assert np.linalg.norm(np.diff(dense, axis=0), axis=1).sum() == pytest.approx(3.51)
    with pytest.raises(CraftmeshError, match="step"):
        densify(line, 0.0)
