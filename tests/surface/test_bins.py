"""Bins find what lies in the cells of a box, as a plain search over all items does."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.surface.kernels.bins import cells_of, cells_of_box, fill_bins, grid_over


def plain_cells(places, low, width, shape):
    """Cells by plain Python, clamped to the grid."""
    return [[min(max(int((x - a) / width), 0), n - 1) for x, a, n in zip(p, low, shape)] for p in places]


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.floats(0.3, 3.0))
def test_bins_hold_each_box_once_in_every_cell_that_it_meets(seed, width):
    rng = np.random.default_rng(seed)
    lower = rng.uniform(-2, 2, (40, 3))
    upper = lower + rng.uniform(0, 1, (40, 3)) * rng.integers(0, 2, (40, 1))  # half of them points
    low, high = np.array([-1.0, -2, -2]), np.array([2.0, 2, 1.5])  # some lie outside
    grid = grid_over(low, high, width)
    first, last = cells_of(lower, grid), cells_of(upper, grid)
    assert first.tolist() == plain_cells(lower, low, width, grid.shape)
    bins = fill_bins(first, last, grid)
    cells = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing="ij"), -1).reshape(-1, 3)
    for c, cell in enumerate(cells):
        wanted = np.flatnonzero(((first <= cell) & (cell <= last)).all(axis=1))
        assert bins.items[bins.start[c] : bins.start[c + 1]].tolist() == wanted.tolist()
    for lowest, highest, from_cell, to_cell in zip(lower, upper, first, last):
        i0, i1, j0, j1, k0, k1 = cells_of_box(grid, lowest, highest)
        assert [i0, j0, k0] == from_cell.tolist() and [i1, j1, k1] == to_cell.tolist()


def test_no_items_make_empty_bins():
    grid = grid_over(np.zeros(3), np.ones(3), 0.5)
    none = cells_of(np.zeros((0, 3)), grid)
    bins = fill_bins(none, none, grid)
    assert bins.start.tolist() == [0] * (3**3 + 1) and len(bins.items) == 0


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_cells_count_along_the_last_axis_first(axis):
    grid = grid_over(np.zeros(3), np.array([1.5, 2.5, 3.5]), 1.0)
    assert grid.shape.tolist() == [2, 3, 4]
    places = np.full((1, 3), 0.5)
    places[0, axis] = 1.5
    cells = cells_of(places, grid)
    bins = fill_bins(cells, cells, grid)
    assert np.flatnonzero(np.diff(bins.start)).tolist() == [[12, 4, 1][axis]]
