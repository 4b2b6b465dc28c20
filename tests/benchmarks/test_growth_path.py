"""How the growth benchmark measures one path against another."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def growth(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    yield importlib.import_module("grown.inclined")
    for name in [name for name in sys.modules if name.split(".")[0] in ("grown", "measure")]:
        sys.modules.pop(name)


def test_distances_are_to_the_nearest_place_of_each_ones_own_path(growth):
    path = np.array([[[6.0, 0], [6, 0]], [[7, 1], [7, 0]], [[9, 1], [9, 0]]])
    places = np.array([[8.0, 1.25], [6.5, 0.5]])
    assert growth.distance_to_path(places, path) == pytest.approx([0.25, 0.5])


def test_directions_are_to_the_first_plane(growth):
    assert growth.direction(np.array([[1.0, 0], [1, 1], [0, -2]])) == pytest.approx([0, 45, -90])


def test_a_circle_in_straight_steps_has_the_direction_of_its_chords_with_half_the_next_kink(growth):
    """Each step goes along the tangent where it starts, as a growing crack's does."""
    angle = np.radians(np.arange(0, 60, 10.0))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    turn = growth.direction(steps)
    assert (turn[:-1] + turn[1:]) / 2 == pytest.approx(np.arange(5, 55, 10.0))
    assert growth.mean_and_most(np.array([-3.0, 1.0])) == pytest.approx([2.0, 3.0])
