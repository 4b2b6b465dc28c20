"""The sizing function: Eq. 2-3, its limits, its errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for
from craftmesh.types import Surface

ORIGIN = np.zeros((1, 3))
FREE = 1e9  # no limit of growth to speak of


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
    step = Sizing(0.5, 1.0, 3.0, 2.0, 2.0, 1.0, ORIGIN, FREE)
    assert at_radius(step, 2.0) == 1.0 and at_radius(step, 2.1) == 3.0
    point = Sizing(0.5, 1.0, 3.0, 0.0, 0.0, 1.0, ORIGIN, FREE)
    assert at_radius(point, 0.0) == 0.5 and at_radius(point, 0.1) == 3.0


def test_lengths_grow_no_faster_than_the_distance_where_nobody_asks_for_it():
    step = sizing_for(None, ORIGIN, SizingOptions(l0=1.0, r0=2.0, r1=2.0))
    assert at_radius(step, 2.0) == 1.0 and at_radius(step, 2.1) == pytest.approx(1.1)
    steep = sizing_for(None, ORIGIN, SizingOptions(l0=1.0, r0=2.0, r1=2.0, gradation=21))
    assert at_radius(steep, 2.05) == pytest.approx(2.0) and at_radius(steep, 2.1) == pytest.approx(3.0)


@settings(max_examples=50)
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
    sizing = sizing_for(surface, ORIGIN, SizingOptions())
    assert (sizing.l_min, sizing.l0, sizing.l_max, sizing.r0, sizing.r1) == (1.0, 2.0, 6.0, 16.0, 32.0)
    assert sizing_for(surface, ORIGIN, SizingOptions(r0=3.0)).r1 == 6.0
    assert sizing_for(surface, ORIGIN, SizingOptions(l0=1.0)).l_max == 3.0


def test_densify_keeps_points_and_bounds_steps():
    line = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 2.5, 0], [1.0, 2.5, 0.01]])
    dense = densify(line, 0.3)
    assert np.linalg.norm(np.diff(dense, axis=0), axis=1).max() <= 0.3 + 1e-12
    assert all((dense == p).all(1).any() for p in line)
    assert np.linalg.norm(np.diff(dense, axis=0), axis=1).sum() == pytest.approx(3.51)
    with pytest.raises(CraftmeshError, match="step"):
        densify(line, 0.0)


@settings(max_examples=30)
@given(st.floats(0.05, 2.0), st.floats(0.3, 5.0), st.floats(0.0, 6.0), st.floats(0.0, 6.0))
def test_limit_is_the_largest_function_below_that_grows_no_faster(growth, exponent, r0, width):
    plain = Sizing(0.5, 1.0, 4.0, r0, r0 + width, exponent, ORIGIN, FREE)
    limited = Sizing(0.5, 1.0, 4.0, r0, r0 + width, exponent, ORIGIN, growth)
    r = np.linspace(0, 20, 801)
    length, before = limited.at_distance(r), plain.at_distance(r)
    assert (length <= before + 1e-12).all()
    assert (np.diff(length) <= growth * np.diff(r) * (1 + 1e-9) + 1e-12).all()
    slow = [(before[: i + 1] + growth * (x - r[: i + 1])).min() for i, x in enumerate(r)]
    # The slow minimum sees Eq. 3 only at the samples, so at most one step's growth above.
    assert (length <= np.array(slow) + 1e-9).all()
    assert (length >= np.array(slow) - growth * (r[1] - r[0]) - 1e-9).all()
    assert limited.at(np.array([[15.0, 0, 0]]))[0] == pytest.approx(limited.at_distance(15.0))


def test_crack_near_voids_has_the_lesser_length_of_both():
    crack = Sizing(0.5, 1.0, 3.0, 4.0, 8.0, 1.0, ORIGIN)
    void = Sizing(0.2, 1.0, 2.0, 2.0, 6.0, 2.0, np.array([[5.0, 0, 0]]))
    both = Sizing(0.5, 1.0, 3.0, 4.0, 8.0, 1.0, ORIGIN, others=(void,))
    points = np.random.default_rng(3).uniform(-3, 9, (300, 3))
    assert np.array_equal(both.at(points), np.minimum(crack.at(points), void.at(points)))
    assert (both.at(points) < crack.at(points)).any() and (both.at(points) < void.at(points)).any()


def test_field_of_lengths_counts_where_it_is_least():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [4, 0, 0]])
    field = LengthField(points, [0.5, 1.0, 1.5, 2.0, 2.5])
    assert np.allclose(field.at(points), field.lengths, rtol=1e-9)
    assert 0.5 < field.at([[0.5, 0, 0]])[0] < 1.2
    sizing = sizing_for(None, np.zeros((0, 3)), SizingOptions(l0=0.5), (field,))
    assert np.allclose(sizing.at(points), [0.5, 1.0, 1.5, 1.5, 1.5])
    with pytest.raises(CraftmeshError, match="lengths.1. is -1"):
        LengthField(points[:2], [1.0, -1.0])
    with pytest.raises(CraftmeshError, match="0 points"):
        LengthField(np.zeros((0, 3)), [])


def test_limited_field_grows_no_faster_between_neighbours():
    points = np.moveaxis(np.indices((9, 9, 9)), 0, -1).reshape(-1, 3).astype(float)
    lengths = np.full(len(points), 5.0)
    lengths[[0, 400]] = 0.5, 1.0
    limited = LengthField(points, lengths).limited(0.25)
    exact = np.min(
        [lengths[i] + 0.25 * np.linalg.norm(points - points[i], axis=1) for i in (0, 400)], axis=0
    )
    exact = np.minimum(exact, 5.0)
    assert (limited.lengths >= exact - 1e-12).all()
    # Ways along neighbours are up to a quarter longer than straight ones.
    assert (limited.lengths <= exact + 0.25 * (exact - exact.min()) + 1e-12).all()
    between = np.random.default_rng(5).uniform(0, 8, (400, 3))
    step = np.random.default_rng(6).normal(scale=0.05, size=(400, 3))
    change = np.abs(limited.at(between + step) - limited.at(between))
    # The nearest samples change from place to place, so single steps are over the limit; measured 3%.
    assert np.percentile(change / np.linalg.norm(step, axis=1), 95) <= 0.25 * (1 + 1e-9)
    options = SizingOptions(l0=2.0, gradation=1.25)
    sizing = sizing_for(None, np.zeros((0, 3)), options, (LengthField(points, lengths),))
    assert np.allclose(sizing.at(points), np.minimum(limited.lengths, 6.0))


def sphere(radius: float) -> Surface:
    from scipy.spatial import ConvexHull

    place = np.arange(1500) + 0.5
    height, turn = 1 - place / 750, np.pi * (1 + 5**0.5) * place
    ring = np.sqrt(1 - height**2)
    points = radius * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    facets = ConvexHull(points).simplices
    a, b, c = (points[facets[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    facets[inward] = facets[inward][:, ::-1]
    return Surface(points, facets, np.tile([1, 0], (len(facets), 1)), np.zeros(len(facets), np.uint8))


@pytest.mark.parametrize("radius", [2.0, 5.0])
def test_curvature_of_a_sphere_gives_one_turn_an_edge(radius):
    sizing = sizing_for(sphere(radius), np.zeros((0, 3)), SizingOptions(l0=1.0, l_min=0.01, curvature=15.0))
    length = sizing.at(sphere(radius).points)
    # The larger of two equal principal curvatures comes out a few percent high.
    assert np.median(length) == pytest.approx(radius * np.radians(15), rel=0.12)
    assert sizing.at(np.zeros((1, 3)))[0] > 1.5 * np.median(length)


def test_gradation_has_to_be_a_ratio_over_one():
    with pytest.raises(CraftmeshError, match="^gradation is 0.8"):
        SizingOptions(gradation=0.8)
