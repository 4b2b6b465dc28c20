"""Edges on curved cracks are short enough to stay on them; flat cracks and kinks ask for nothing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.sizing.bends import OFF, bend_lengths
from craftmesh.sizing.sizing import Sizing
from craftmesh.types import Crack

BOX = np.array([[0.0, 0, 0], [40, 40, 40]])
L_MIN = 0.5


def sheet(height, count: int = 81) -> Crack:
    """A crack of a height (x, y) over the whole box, without a front."""
    x, y = (one.ravel() for one in np.meshgrid(*[np.linspace(0, 40, count)] * 2, indexing="ij"))
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    lower = np.stack([corner, corner + count, corner + count + 1], axis=1)
    triangles = np.concatenate([lower, np.stack([corner, corner + count + 1, corner + 1], axis=1)])
    return Crack(np.column_stack([x, y, height(x, y)]), triangles, ())


def sizing(l_max: float = 20.0) -> Sizing:
    return Sizing(L_MIN, 2.0, l_max, 4.0, 8.0, 1.0, np.zeros((0, 3)))


@settings(max_examples=20, deadline=None)
@given(radius=st.floats(25.0, 300.0))
def test_a_chord_of_a_cylinder_is_off_by_what_is_allowed(radius):
    lengths = bend_lengths(
        sheet(lambda x, y: np.sqrt(radius**2 - (x - 20) ** 2) - radius + 20), BOX, sizing()
    )
    middle = lengths.at(np.array([[20.0, 20.0, 20.0]]))[0]
    # the crack's triangles are half a unit wide: between samples a length grows by up to a quarter of it;
    # turns across the triangles' diagonals are over a part of their distance
    assert middle**2 / (8 * radius) == pytest.approx(OFF * L_MIN, rel=0.35)
    assert lengths.lengths.min() >= L_MIN


def test_a_bend_that_is_too_narrow_asks_for_l_min():
    lengths = bend_lengths(sheet(lambda x, y: 20 + 0.9 * np.sin(x), 321), BOX, sizing())
    assert lengths.lengths.min() == L_MIN


@pytest.mark.parametrize("slope", [0.0, 0.7])
def test_flat_cracks_and_kinks_ask_for_nothing(slope):
    assert bend_lengths(sheet(lambda x, y: 20 + slope * np.abs(x - 20)), BOX, sizing()) is None


def test_bends_outside_the_box_and_those_with_short_edges_anyway_do_not_count():
    bent = sheet(lambda x, y: np.sqrt(50**2 - (x - 20) ** 2) - 30)
    assert bend_lengths(bent, BOX + 100, sizing()) is None
    assert bend_lengths(bent, BOX, sizing(l_max=2.0)) is None
