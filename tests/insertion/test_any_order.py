"""Facets and points of a crack in any order and turn: the same surface, bit for bit."""

import numpy as np
import pytest
from given_cracks import over_grid, wavy_disc
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from models import voronoi

from craftmesh import Surface, insert_crack
from craftmesh.cracks.sheets import cracks_from_triangles
from craftmesh.remeshing.remesh import remesh

X, Y = np.meshgrid(np.linspace(-1, 7.2, 9), np.linspace(-1, 15, 17), indexing="ij")
DISC = wavy_disc(3.0, 0.6, rings=4)
UNDER = DISC[0] + [7.1, 7.1, 3.0]
SHEETS = {
    "kink": over_grid(X, Y, 6.3 + 0.9 * np.maximum(0, X - 3.1)),
    "two": (
        np.concatenate([DISC[0] + [7.1, 7.1, 9.0], UNDER]),
        np.concatenate([DISC[1], DISC[1] + len(UNDER)]),
    ),
}


@pytest.fixture(scope="module")
def grains() -> Surface:
    return remesh(voronoi(3, 4, (14, 14, 14)))[0]


@pytest.mark.parametrize("sheet", SHEETS)
@settings(max_examples=1, phases=[Phase.generate])
@given(seed=st.integers(0, 2**32 - 1))
def test_a_crack_comes_in_alike_however_its_facets_are_given(grains, sheet, seed):
    points, triangles = SHEETS[sheet]
    one, other = (
        insert_crack(grains, cracks_from_triangles(*given, None, grains.box))[0]
        for given in ((points, triangles), shuffled(points, triangles, np.random.default_rng(seed)))
    )
    for name in ("points", "facets", "sides", "kind"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def shuffled(points: np.ndarray, triangles: np.ndarray, rng: np.random.Generator) -> tuple:
    """Return points and triangles in a random order, of these a third turned over: most tell lip A."""
    order = rng.permutation(len(points))
    turned = np.argsort(order)[rng.permutation(triangles)]
    turns = rng.integers(3, size=(len(turned), 1)) + np.arange(3)
    turned = np.take_along_axis(turned, turns % 3, axis=1)
    over = rng.random(len(turned)) < 1 / 3
    turned[over] = turned[over, ::-1]
    return points[order], turned
