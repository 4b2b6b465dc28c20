"""Steps of a load: where they begin and end, and what is between."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.history import parse_steps


def at(step, times):
    return np.interp(times, *step.table().T)


@given(
    kind=st.sampled_from(["triangle", "sine"]),
    peak=st.sampled_from([-2.0, 0.5, 1.0]),
    ratio=st.floats(-2, 0.9),
    start=st.floats(0, 1),
    cycles=st.integers(1, 4),
)
def test_whole_cycles_reach_peak_and_valley_and_end_where_they_began(kind, peak, ratio, start, cycles):
    begin = peak * (ratio + start * (1 - ratio))
    texts = [f"ramp:{begin!r}", f"{kind}:{peak},R={ratio!r},cycles={cycles},time=3,increments=400"]
    _, step = parse_steps(texts, [])
    times, levels = step.table().T
    assert (np.diff(times) > 0).all() and times[-1] == pytest.approx(3 * cycles)
    assert levels[[0, -1]] == pytest.approx([begin, begin], abs=1e-7)
    # 400 points a cycle miss the peak of a sine by 1 - cos(pi / 400) of its half range at most
    reach = 4e-5 * abs(peak) * (1 - ratio)
    low, high = sorted([peak, peak * ratio])
    assert levels.max() == pytest.approx(high, abs=reach) and levels.min() == pytest.approx(low, abs=reach)
    assert abs(levels[1] - peak) <= abs(levels[0] - peak) + 1e-9 or start > 0.99  # towards the peak first


def test_a_triangle_is_straight_between_its_turning_points():
    (step,) = parse_steps(["triangle:2,R=-1,cycles=2"], [])
    assert step.table().tolist() == [[0, 0], [0.25, 2], [0.75, -2], [1.25, 2], [1.75, -2], [2, 0]]
    (half,) = parse_steps(["triangle:1,cycles=0.5"], [])
    assert half.table().tolist() == [[0, 0], [0.5, 1]] and half.end == 1


def test_a_triangle_is_ramps_of_one_rate_between_its_turning_points():
    (step,) = parse_steps(["triangle:2,R=-1,time=4,increments=40"], [])
    pieces = step.pieces()
    assert [(one.start, one.level, one.time) for one in pieces] == [(0, 2, 1), (2, -2, 2), (-2, 0, 1)]
    assert {one.time / one.increments for one in pieces} == {0.1}


def test_steps_go_on_where_the_one_before_ended():
    steps = parse_steps(["ramp:0.3", "sine:1,R=0.1,cycles=1.3", "ramp:0"], [])
    assert steps[1].start == 0.3 and steps[2].start == pytest.approx(steps[1].table()[-1, 1])
    one, other = parse_steps(["a/ramp:0.5", "b/ramp:1"], ["a", "b"])
    assert (one.load, other.load, other.start) == ("a", "b", 0)


@pytest.mark.parametrize(
    ("texts", "loads", "said"),
    [
        (["ramp"], [], "'ramp'; expected ramp:LEVEL"),
        (["saw:1"], [], "expected ramp:LEVEL"),
        (["ramp:1,R=-1"], [], "expected ramp:LEVEL"),
        (["sine:1,cycles=0"], [], "expected ramp:LEVEL"),
        (["sine:1,R=1"], [], "expected ramp:LEVEL"),
        (["sine:1,time=1,time=2"], [], "expected ramp:LEVEL"),
        (["sine:1,R=0.5"], [], "from 0.5 to 1, but the load is at 0 .* a ramp to 0.5 before"),
        (["shear/ramp:1"], ["tension"], "load 'shear'; expected one of tension"),
        (["ramp:1"], ["tension"], "load ''; expected one of tension"),
        (["x/ramp:1"], [], "there is one load"),
        (["a/ramp:1", "b/sine:1"], ["a", "b"], "begins cycles of b while a is at 1; put b/ramp"),
    ],
)
def test_texts_that_are_no_steps_are_refused(texts, loads, said):
    with pytest.raises(CraftmeshError, match=said):
        parse_steps(texts, loads)
