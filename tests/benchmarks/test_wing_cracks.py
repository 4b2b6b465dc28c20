"""K of wing cracks, against a straight crack, a short kink and long wings."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

import wing_cracks  # noqa: E402

END = np.exp(1j * np.pi / 4)
PRESSED = (0.0, -1.0, 0.0)


@pytest.mark.parametrize("degrees", [0, 30, 90])
def test_a_wing_along_the_main_crack_makes_a_longer_crack(degrees):
    way = np.exp(1j * np.radians(degrees))
    stress = (0.4, 1.0, 0.3)
    load = wing_cracks.far_traction(way, stress)
    found = wing_cracks.tip_k([way, 1.3 * way], stress, 0.5)
    assert found == pytest.approx(np.sqrt(1.3 * np.pi) * np.array([load.real, load.imag]), rel=0.01)


def test_k_of_a_short_kink_is_that_of_the_kinked_tip():
    """To first order (Cotterell & Rice 1980), without a stress along the crack."""
    half = np.radians(30) / 2
    found = wing_cracks.tip_k([1.0, 1 + 0.05 * np.exp(2j * half)], (1.0, 1.0, 0.0), 0.0)
    known = np.sqrt(np.pi) * np.cos(half) ** 2 * np.array([np.cos(half), np.sin(half)])
    assert found == pytest.approx(known, rel=0.05)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_long_wings_are_wedged_by_the_sliding_main_crack(friction):
    """Horii & Nemat-Nasser (1986): wings along the pressure, 0.27 longer so that short ones are right."""
    lengths = np.array([0.5, 1.0, 2.0, 4.0])
    force = (1 - friction) * np.sin(np.pi / 4)
    known = force / np.sqrt(np.pi * (lengths + 0.27))
    found = [wing_cracks.tip_k([END, END + 1j * length], PRESSED, friction)[0] for length in lengths]
    assert np.array(found) == pytest.approx(known, rel=0.07)


def test_a_wing_turns_towards_the_pressure_by_less_and_less_and_steps_do_not_matter():
    coarse, fine = (wing_cracks.wing_path(END, PRESSED, 0.3, 0.25 / cut, 4 * cut) for cut in (1, 2))
    ways = np.degrees(np.angle(np.diff(fine)))
    assert (np.diff(ways) < 0).all() and ways[0] > 110 and 90 < ways[-1] < 100
    assert np.abs(coarse - fine[::2]).max() < 0.01
