"""Kink angles against known ones, and what must hold of any criterion."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.kink_angle import (
    energy_release,
    kink_angles,
    kink_angles_of,
    kink_factors,
    tangential_intensity,
)
from craftmesh.growth.options import GrowthOptions

BOTH = pytest.mark.parametrize("criterion", ["tangential_stress", "energy_release"])


def angle(k, criterion="tangential_stress"):
    return float(np.degrees(kink_angles(np.array([k]), criterion, 0.3)[0]))


@BOTH
def test_pure_opening_goes_straight_on(criterion):
    assert angle((2.0, 0.0, 0.0), criterion) == pytest.approx(0, abs=1e-3)


def test_pure_sliding_kinks_by_the_known_angles():
    # 70.53 degrees: cos t = 1/3 (Erdogan & Sih); 75.6-75.8: Amestoy & Leblond's series
    assert angle((0.0, 1.0, 0.0)) == pytest.approx(-np.degrees(np.arccos(1 / 3)), abs=1e-9)
    assert angle((0.0, 1.0, 0.0), "energy_release") == pytest.approx(-75.7, abs=0.15)


def test_the_kink_without_sliding_in_mode_ii_stands_at_77_3_degrees():
    # the angle of local symmetry in pure mode II (Amestoy & Leblond 1992: 77.3)
    before, after = kink_factors(np.radians([-77.2, -77.5]))[3]
    assert before * after < 0


# F_11, F_12, F_21, F_22 by the series printed in Amestoy & Leblond (1992), from another transcription of it
PRINTED = {
    -80: (0.463591159896, 1.229047844515, -0.370435120723, -0.044256518445),
    20: (0.955219914849, -0.506828594585, 0.168012054761, 0.907147218958),
    50: (0.747788934443, -1.066462182074, 0.342942096934, 0.487257118025),
    85: (0.416991472203, -1.216294553128, 0.360942060290, -0.123328303717),
}


@pytest.mark.parametrize("degrees", PRINTED)
def test_the_intensities_of_a_short_kink_are_the_printed_ones(degrees):
    # the last digit of the last coefficient makes 3e-9 at 85 degrees
    assert kink_factors(np.radians(degrees)) == pytest.approx(PRINTED[degrees], abs=1e-11)


@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_the_energy_of_all_modes_is_irwins_straight_ahead_and_sihs_of_a_kink_under_tearing(poisson):
    k = np.array([[2.0, 0.5, 0.7], [0.0, 0.0, 1.0]])
    angle = np.radians([[0.0, 60.0, -60.0]])
    found = energy_release(k, angle, poisson)
    assert found[0, 0] == pytest.approx(2.0**2 + 0.5**2 + 0.7**2 / (1 - poisson))
    # K_III of a kink by m pi is ((1 - m) / (1 + m))^(m / 2) of what it was (Sih 1965)
    assert found[1] == pytest.approx(np.array([1, 0.5 ** (1 / 3), 0.5 ** (1 / 3)]) / (1 - poisson))


@given(st.floats(0.1, 5), st.floats(-5, 5), st.floats(-2, 2))
def test_the_tangential_stress_has_its_maximum_there(k1, k2, k3):
    k = np.array([[k1, k2, k3]])
    best = kink_angles(k, "tangential_stress", 0.3)
    around = best + np.radians(np.linspace(-40, 40, 81))
    here = tangential_intensity(k, best)
    assert (tangential_intensity(np.repeat(k, 81, axis=0), around) <= here * (1 + 1e-12)).all()


@given(st.floats(0.1, 5), st.floats(-5, 5), st.floats(-2, 2))
def test_the_energy_release_has_its_maximum_there(k1, k2, k3):
    k = np.array([[k1, k2, k3]])
    best = kink_angles(k, "energy_release", 0.3)
    around = np.radians(np.linspace(-85, 85, 1701))[None]
    assert energy_release(k, around, 0.3).max() <= energy_release(k, best[:, None], 0.3)[0, 0] * (1 + 1e-6)


@BOTH
@given(st.floats(0, 5), st.floats(-5, 5))
def test_turning_the_sliding_turns_the_kink(criterion, k1, k2):
    # 2e-4: the last halving of the search for the energy's peak, degrees
    assert angle((k1, k2, 0.0), criterion) == pytest.approx(-angle((k1, -k2, 0.0), criterion), abs=2e-4)


@BOTH
def test_a_little_sliding_turns_by_twice_its_share(criterion):
    assert np.radians(angle((1.0, 0.01, 0.0), criterion)) == pytest.approx(-0.02, rel=2e-3)


@BOTH
def test_a_closed_crack_counts_as_one_without_opening(criterion):
    assert angle((-3.0, 1.0, 0.0), criterion) == angle((0.0, 1.0, 0.0), criterion)


def turned_by(criterion, k):
    return kink_angles_of(FrontPoints.of(k, 1.0), GrowthOptions(criterion=criterion))


def test_a_criterion_of_ones_own_is_taken_and_gets_k_as_it_is(monkeypatch):
    given = []
    own = SimpleNamespace(straight=lambda front: given.append(front.k) or np.zeros(len(front.k)))
    monkeypatch.setitem(sys.modules, "own_rule", own)
    k = np.array([[30.0, -4.0, 2.0], [-1.0, 0.0, 0.0]])
    assert (turned_by("own_rule:straight", k) == 0).all()
    assert (given[0] == k).all()


@pytest.mark.parametrize("name", ["steepest", "no_such_module:rule", "math:no_such_function"])
def test_a_criterion_that_is_not_there_is_refused(name):
    with pytest.raises(CraftmeshError, match=f"^criterion .*{name}"):
        turned_by(name, np.ones((1, 3)))


def test_a_criterion_that_returns_something_else_is_refused():
    with pytest.raises(CraftmeshError, match="expected 2 finite numbers"):
        turned_by("numpy:shape", np.ones((2, 3)))
