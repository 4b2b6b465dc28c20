"""K of cracks next to each other or to a face, against limits that are known in closed form."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

import neighbours  # noqa: E402
from neighbours import CoplanarPennies, below_face, slope_kernel, square_to_face  # noqa: E402


def test_two_pennies_far_apart_feel_each_others_stress_alone():
    pair, r = CoplanarPennies(20.0), np.array([1.5, 3.0, 20.0])
    alone = 2 / np.pi * (1 / np.sqrt(r**2 - 1) - np.arcsin(1 / r))  # Sneddon, of a uniform pressure
    assert pair.stress(r, 0 * r) == pytest.approx(alone, rel=1e-4)  # the other raises it by 3e-5
    assert pair.k1(np.array([np.pi / 2]))[0] - 1 == pytest.approx(alone[-1], rel=0.02)  # of second order


def test_k_of_two_pennies_does_not_depend_on_the_places_in_them(monkeypatch):
    angle = np.linspace(0, np.pi, 5)
    coarse = CoplanarPennies(2.5).k1(angle)
    monkeypatch.setattr(neighbours, "RINGS", 32)
    monkeypatch.setattr(neighbours, "SPOKES", 128)
    assert CoplanarPennies(2.5).k1(angle) == pytest.approx(coarse, abs=1e-9)
    assert (np.diff(coarse) < 0).all()  # it falls from the end next to the other penny on


def test_a_penny_below_a_face_is_alone_if_deep_and_a_clamped_plate_if_shallow(monkeypatch):
    assert below_face(50.0) == pytest.approx((1, 0), abs=1e-5)
    monkeypatch.setattr(neighbours, "TERMS", 60)
    # moment 1/8 at the rim of a clamped plate; its shares of modes I and II: Suo & Hutchinson (1990)
    unit = np.sqrt(6) / 8 / (2 / np.sqrt(np.pi))
    off = []
    for depth in (0.1, 0.05, 0.03):
        plate = unit * depth**-1.5 * np.array([np.sin(np.radians(52.07)), -np.cos(np.radians(52.07))])
        off.append(below_face(depth) / plate - 1)
    # the plate is clamped in an elastic body: the difference falls with the depth
    assert np.abs(off[-1]).max() < 0.09 and (np.diff(np.abs(off), axis=0) < 0).all()


def test_a_crack_far_from_a_face_feels_the_stress_of_its_image():
    near, far = square_to_face(30.0)
    assert near - 1 == pytest.approx(1 / (4 * 30.0**2), rel=0.05)
    assert far - 1 == pytest.approx(near - 1, rel=0.1)


def test_the_kernel_of_a_face_gives_the_edge_crack():
    found = []
    for count in (200, 400):
        s = np.cos(np.pi * (np.arange(count) + 0.5) / (2 * count))
        x = np.cos(np.pi * np.arange(1, count) / (2 * count))[:, None]
        system = np.vstack([slope_kernel(x, s) / (2 * count), np.eye(count)[-1:]])
        g = np.linalg.solve(system, np.append(np.ones(count - 1), 0.0))
        found.append(g[0] + (g[0] - g[1]) / 8)  # at s = 1; the first two are at 1/16 and 9/16 of pi^2 / n^2
    # errors fall with the number of points
    assert 2 * found[1] - found[0] == pytest.approx(1.12152, abs=3e-4)
