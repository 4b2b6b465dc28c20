"""Kink angles against known ones, and what must hold of any criterion."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.growth.kink_angle import driving_intensity, energy_release, kink_angles, kink_factors

BOTH = pytest.mark.parametrize("criterion", ["tangential_stress", "energy_release"])


def angle(k, criterion="tangential_stress"):
    return float(np.degrees(kink_angles(np.array([k]), criterion)[0]))


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


@given(st.floats(0.1, 5), st.floats(-5, 5), st.floats(-2, 2))
def test_the_tangential_stress_has_its_maximum_there(k1, k2, k3):
    k = np.array([[k1, k2, k3]])
    best = kink_angles(k, "tangential_stress")
    around = best + np.radians(np.linspace(-40, 40, 81))
    here = driving_intensity(k, best)
    assert (driving_intensity(np.repeat(k, 81, axis=0), around) <= here * (1 + 1e-12)).all()


@given(st.floats(0.1, 5), st.floats(-5, 5), st.floats(-2, 2))
def test_the_energy_release_has_its_maximum_there(k1, k2, k3):
    k = np.array([[k1, k2, k3]])
    best = kink_angles(k, "energy_release")
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


def test_a_criterion_of_ones_own_is_taken(monkeypatch):
    monkeypatch.setitem(sys.modules, "own_rule", SimpleNamespace(straight=lambda k: np.zeros(len(k))))
    assert (kink_angles(np.ones((4, 3)), "own_rule:straight") == 0).all()


@pytest.mark.parametrize("name", ["steepest", "no_such_module:rule", "math:no_such_function"])
def test_a_criterion_that_is_not_there_is_refused(name):
    with pytest.raises(CraftmeshError, match=f"^criterion .*{name}"):
        kink_angles(np.ones((1, 3)), name)


def test_a_criterion_that_returns_something_else_is_refused():
    with pytest.raises(CraftmeshError, match="expected 2 finite angles"):
        kink_angles(np.ones((2, 3)), "numpy:ravel")
