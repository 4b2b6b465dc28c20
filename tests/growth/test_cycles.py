"""Load cycles along a path whose K are known, and the laws that they are counted by."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.growth.extension import kinks_and_extensions
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.kink_angle import kink_angles, tangential_intensity
from craftmesh.growth.options import GrowthOptions
from craftmesh.growth.rates import LoadCycle, laws_of, local_rates, open_share, opening_level, parse_rates
from craftmesh.growth.steps import counted, step_length

C, SIZE = 1e-3, 6.0


def at(driving, ratio=0.0):
    """Return a load cycle with K_I alone, without closure."""
    ratio = np.broadcast_to(ratio, driving.shape)
    front = FrontPoints.of(np.outer(driving, [1.0, 0.0, 0.0]), 1.0)
    return LoadCycle(driving, ratio, (1 - np.maximum(ratio, 0)) * driving, 0 * driving, front)


def penny(options, steps, slope=0.5):
    """Return the fronts of a penny whose K goes with a power of its radius, and how far it has come."""
    size, last, found = SIZE, None, []
    for _ in range(steps):
        k = np.outer(np.full(5, size**slope), [1.0, 0.0, 0.0])
        last = kinks_and_extensions(FrontPoints.of(k, size, last=last), options)[1]
        found.append(last)
        size += last.step
    return found


@given(st.floats(0.05, 0.5), st.floats(2.1, 5))
@settings(max_examples=20)
def test_cycles_of_a_penny_are_exact_however_long_the_steps(share, m):
    *_, last = penny(GrowthOptions(share=share, exponent=m, coefficient=C), 5)
    powers = [size ** (1 - m / 2) for size in (SIZE, last.size, last.size + last.step)]
    exact = -np.diff(powers) / (C * (m / 2 - 1))
    assert [last.cycles, last.ahead] == pytest.approx(exact, rel=1e-9)


def test_cycles_where_k_goes_otherwise_are_within_their_doubt():
    def k_of(size):
        return np.sqrt(size) * (1 + (size / 20) ** 3)

    options = GrowthOptions(share=0.25, exponent=3.0, coefficient=C, law="uniform")
    size, last = SIZE, None
    for _ in range(5):
        k = np.outer(np.full(5, k_of(size)), [1.0, 0.0, 0.0])
        last = kinks_and_extensions(FrontPoints.of(k, size, last=last), options)[1]
        size += last.step
    sizes = np.linspace(SIZE, last.size, 100_001)
    exact = np.trapezoid(1 / (C * k_of(sizes) ** 3), sizes)
    assert abs(last.cycles - exact) < last.doubt < 0.02 * exact
    sizes = np.linspace(last.size, size, 100_001)
    assert abs(last.ahead - np.trapezoid(1 / (C * k_of(sizes) ** 3), sizes)) < last.ahead_doubt


def test_an_error_of_k_that_is_the_same_everywhere_is_in_the_doubt():
    first = counted(None, 6.0, 1.5, 1e-3, 3.0, 0.01)
    second = counted(first, 7.5, 1.5, 1.3e-3, 3.0, 0.01)
    off = counted(first._replace(rate=1e-3 * 1.01**3), 7.5, 1.5, 1.3e-3 * 1.01**3, 3.0, 0.01)
    # 3 %, and the way between the fronts
    assert abs(off.cycles / second.cycles - 1) < second.doubt / second.cycles < 0.035


def test_a_front_that_stands_has_the_cycles_that_were_foreseen():
    options = GrowthOptions(share=0.25, coefficient=C, threshold=1.0)
    first = kinks_and_extensions(FrontPoints.of(np.eye(4, 3) + [1.5, 0, 0], 6.0), options)[1]
    stands, ahead = kinks_and_extensions(
        FrontPoints.of(np.full((4, 3), [0.5, 0, 0]), 7.5, last=first), options
    )
    assert (stands.extension == 0).all() and ahead.ahead == 0
    assert ahead.cycles == first.ahead > 0 and ahead.doubt == first.ahead_doubt > 0


@given(st.floats(0.05, 0.5), st.floats(2.1, 5), st.sampled_from([0.5, 0.25, 0.8]))
@settings(max_examples=20)
def test_a_step_laid_in_part_has_the_cycles_of_that_part(share, m, laid):
    """Of a penny whose steps are whole but the third; in counting on it is as if the step were so short."""
    options = GrowthOptions(share=share, exponent=m, coefficient=C)
    whole = penny(options, 3)[-1]
    part = whole.laid(laid)
    size = part.size + laid * whole.step

    def exact(start, end):
        return -np.diff([start ** (1 - m / 2), end ** (1 - m / 2)])[0] / (C * (m / 2 - 1))

    assert part.step == laid * whole.step and part.cycles == whole.cycles
    assert part.ahead == pytest.approx(exact(part.size, size), rel=1e-9)
    k = np.outer(np.full(5, size**0.5), [1.0, 0.0, 0.0])
    reached = kinks_and_extensions(FrontPoints.of(k, size, last=part), options)[1]
    assert reached.cycles == pytest.approx(exact(SIZE, size), rel=1e-9)
    assert reached.growth == pytest.approx(m / 2)
    assert whole.laid(1.0) == whole


def test_a_front_that_did_not_move_takes_no_cycles():
    still = penny(GrowthOptions(share=0.2, coefficient=C), 3)[-1].laid(0.0)
    k = np.outer(np.full(5, still.size**0.5), [1.0, 0.0, 0.0])
    options = GrowthOptions(share=0.2, coefficient=C)
    reached = kinks_and_extensions(FrontPoints.of(k, still.size, last=still), options)[1]
    assert reached.cycles == still.cycles and reached.doubt == still.doubt


def test_a_step_is_as_long_as_k_lets_it_and_the_front_and_its_edges():
    options = GrowthOptions()
    assert step_length(options, 6.0, np.inf, 0.5, 0.5, 1.0) == pytest.approx(6 * 0.21)
    assert step_length(options, 6.0, np.inf, 0.1, 2.0, 1.0) == pytest.approx(6 * (1.1**0.5 - 1))
    assert step_length(options, 6.0, 4.0, 0.5, 0.5, 1.0) == pytest.approx(0.8)  # a thin plate
    assert step_length(options, 6.0, 4.0, 1.0, 0.5, 1.0) == 1.0
    assert step_length(GrowthOptions(share=0.25), 6.0, 4.0, 1.0, 0.5, 1.0) == 1.5
    assert step_length(GrowthOptions(share=0.25, extension=2.0), 6.0, 4.0, 1.0, 0.5, 1.0) == 2.0


def test_a_step_of_its_own_takes_no_point_too_far_and_one_that_is_given_does():
    lengths = [step_length(GrowthOptions(), 6.0, np.inf, 0.1, 0.5, far) for far in (1.0, 2.0, 8.0)]
    assert lengths == pytest.approx([6 * 0.21, 6 * 0.21, 6 * 0.21 / 4])
    assert step_length(GrowthOptions(extension=1.0), 6.0, np.inf, 0.1, 0.5, 8.0) == 1.0


@pytest.mark.parametrize(
    ("options", "ratios"),
    [
        ({}, [0.2, 1.0, 2.0]),
        ({"threshold": 0.1}, [0.125, 1.0, 2.0]),
        ({"coefficient": C}, [0.125, 1.0, 8.0]),
        ({"rates": ("paris:1e-9,3",)}, [0.125, 1.0, 8.0]),
    ],
)
def test_a_law_of_rates_is_not_clipped(options, ratios):
    k = np.outer([0.5, 1.0, 2.0], [1.0, 0, 0])
    found, _ = kinks_and_extensions(
        FrontPoints.of(k, 6.0), GrowthOptions(law="power", extension=1.0, **options)
    )
    assert found.rate == pytest.approx(ratios) and found.extension == pytest.approx(ratios)
    scale = {"coefficient": C, "rates": 1e-9}.get(next(iter(options), ""), 1.0)
    assert found.da_dn == pytest.approx(scale * np.array([0.125, 1.0, 8.0]))


def test_a_table_goes_through_its_points_and_stands_up_to_the_first():
    laws = parse_rates(["table:5,1e-9,10,1e-7,40,1e-5"])
    here = local_rates(laws, np.arange(7), np.zeros(7, int))
    span = np.array([4.0, 5.0, 10.0, 20.0, 40.0, 80.0, np.sqrt(50)])
    assert here.rate(at(span)) == pytest.approx([0, 0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-8])


def test_laws_are_those_of_the_grain_then_of_its_phase_then_of_all():
    laws = parse_rates(["paris:1,0", "2=paris:2,0", "GRAIN_7=paris:3,0,0.5"])
    here = local_rates(laws, np.array([1, 5, 7, 7]), np.array([1, 2, 2, 2]))
    assert here.rate(at(np.array([1.0, 1.0, 1.0, 0.5]))).tolist() == [1, 2, 3, 0]
    with pytest.raises(CraftmeshError, match="no law for grain 1 of phase 1"):
        local_rates(parse_rates(["2=paris:2,0"]), np.array([1]), np.array([1]))


@pytest.mark.parametrize(
    "text",
    [
        "paris",
        "paris:1",
        "paris:-1,3",
        "paris:1,2,3,4",
        "walker:1,2",
        "walkr:1,2,3",
        "table:1,2",
        "table:2,1,1,2",
        "A=paris:1,3",
    ]
    + ["table:1,2,3", "table:1,2,2,1", "paris:nan,3", "GRAIN_x=paris:1,3", "paris:1,3:4"],
)
def test_texts_that_are_no_law_are_refused(text):
    with pytest.raises(CraftmeshError, match="^grow.rates: "):
        parse_rates([text])


def test_two_laws_for_one_place_are_refused():
    with pytest.raises(CraftmeshError, match="second law"):
        parse_rates(["1=paris:1,3", "1=paris:2,3"])
    with pytest.raises(CraftmeshError, match="grow.coefficient"):
        laws_of(GrowthOptions(rates=("paris:1,3",), coefficient=1.0))


@given(st.floats(1, 3), st.floats(0.05, 0.95))
@settings(max_examples=20)
def test_newmans_crack_opens_between_the_least_load_and_the_largest(alpha, largest):
    ratios = np.linspace(-1, 0.999, 50)
    levels = np.array([opening_level(ratio, alpha, largest) for ratio in ratios])
    assert (levels >= ratios).all() and (levels < 1).all() and (np.diff(levels) > -1e-9).all()


@pytest.mark.parametrize("alpha", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("largest", [0.2, 0.4, 0.8])
def test_newmans_opening_level_is_that_of_his_paper(alpha, largest):
    """Newman (1984): f goes into R at R = 1 with its slope, and from R = 0 with slope A_1."""
    a0 = (0.825 - 0.34 * alpha + 0.05 * alpha**2) * np.cos(np.pi * largest / 2) ** (1 / alpha)
    a1 = (0.415 - 0.071 * alpha) * largest
    a3 = 2 * a0 + a1 - 1
    a2 = 1 - a0 - a1 - a3
    ratios = np.array([-2.0, -1.0, -0.5, 0.0, 0.3, 0.5, 0.7, 0.9])
    cubic = a0 + a1 * ratios + a2 * ratios**2 + a3 * ratios**3
    expected = np.where(ratios < 0, a0 + a1 * ratios, np.maximum(cubic, ratios))
    assert opening_level(ratios, alpha, largest) == pytest.approx(expected, abs=1e-14)
    near_one = np.array([1 - 1e-4, 1.0])
    assert opening_level(near_one, alpha, largest) == pytest.approx(near_one, abs=1e-7)


def test_newmans_opening_level_has_the_values_of_his_formulas_by_hand():
    """Plane stress and plane strain, S_max a fifth of the flow stress, by his formulas."""
    found = [opening_level(np.array([0.0, 0.5]), alpha, 0.2) for alpha in (1.0, 3.0)]
    # A_0 = .535 cos(18 deg) and .255 cos(18 deg)^(1/3); at R = .5 A_0 + A_1 / 2 + A_2 / 4 + A_3 / 8
    assert found[0] == pytest.approx([0.50882, 0.63801], abs=1e-5)
    assert found[1] == pytest.approx([0.25077, 0.50543], abs=1e-5)


def test_the_share_of_a_cycle_in_which_the_crack_is_open():
    # plane stress and plane strain: A_0 of Newman's (1984) fit by hand
    assert opening_level(0.0, 1.0, 0.0) == pytest.approx(0.535)
    assert opening_level(0.0, 3.0, 0.5) == pytest.approx(0.255 * 2 ** (-1 / 6))
    assert open_share("none", 0.5) == 0.5 and open_share("none", -1.0) == 1.0
    assert open_share("open:0.8", 0.5) == pytest.approx(0.4)
    assert open_share("newman:2,0.3", 0.1) == 1 - opening_level(0.1, 2.0, 0.3)


@pytest.mark.parametrize(
    "text", ["half", "open:0", "open:1.5", "open", "newman:2", "newman:4,0.3", "none:1"]
)
def test_other_closures_are_refused(text):
    with pytest.raises(CraftmeshError, match="^grow.closure is "):
        open_share(text, 0.0)


def pair(k, least, **options):
    loads = {"most": np.array(k), "least": np.array(least)}
    front = FrontPoints.of(np.array(k), 6.0, loads=loads)
    return kinks_and_extensions(front, GrowthOptions(cycle=("most", "least"), **options))[0]


def test_each_point_of_a_cycle_between_two_loads_has_its_own_range():
    largest = [[2.0, 0.0, 0.0], [2.0, 0.5, 0.0], [2.0, 0.0, 0.7], [1.0, -0.4, 0.2]]
    least = [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [-1.0, 0.0, 0.7], [3.0, 0.1, 0.0]]
    found = pair(largest, least)
    angle = kink_angles(np.array(largest), "tangential_stress", 0.3)
    # opening and sliding each by its own difference, along the kink of the largest load
    change = tangential_intensity(np.subtract(largest, least), angle)
    assert found.delta_k[:2] == pytest.approx(change[:2], rel=1e-12)
    assert found.ratio[:3] == pytest.approx([0.25, 1 - change[1] / found.driving[1], -0.5])
    assert found.delta_k[2] == 2.0  # shut lips carry the rest
    # the other end is the larger at the last point, whichever comes first
    turned = pair(least, largest)
    assert found.driving[3] == pytest.approx(3.0, abs=0.1)
    for name in ("kink_angle", "driving", "delta_k", "ratio"):
        assert getattr(turned, name) == pytest.approx(getattr(found, name), rel=1e-12)


def test_a_cycle_in_proportion_is_that_of_its_stress_ratio():
    k = np.random.default_rng(5).uniform([1, -1, -1], [3, 1, 1], (20, 3))
    for closure in ("none", "open:0.7", "newman:2,0.3"):
        own = {"closure": closure, "law": "power", "coefficient": 1e-9}
        found, known = (
            pair(k, -0.4 * k, **own),
            kinks_and_extensions(FrontPoints.of(k, 6.0), GrowthOptions(**own, stress_ratio=-0.4))[0],
        )
        assert found.ratio == pytest.approx(-0.4) and found.delta_k == pytest.approx(known.delta_k)
        assert found.extension == pytest.approx(known.extension)
