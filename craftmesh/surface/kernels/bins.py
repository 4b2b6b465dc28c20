"""Bins: which points or boxes lie in each cell of a grid, for questions about what is near."""

from collections import namedtuple

import numpy as np

from craftmesh.jit import kernel, lean_kernel

# Cells of one `width` from the corner `low` (3,) on, `shape` (3,) of them along the axes. What lies outside
# counts as in the outermost cells.
Grid = namedtuple("Grid", "low width shape")
# The items of cell c are items[start[c] : start[c + 1]], ascending. Cells count along the last axis first.
Bins = namedtuple("Bins", "start items grid")


def grid_over(low: np.ndarray, high: np.ndarray, width: float) -> Grid:
    """Return the grid of cells of `width` over the box from `low` (3,) to `high` (3,)."""
    return Grid(np.array(low, float), float(width), ((high - low) / width).astype(np.int64) + 1)


@lean_kernel
def _cell(grid, x, axis):
    return min(max(int((x - grid.low[axis]) / grid.width), 0), grid.shape[axis] - 1)


@kernel
def cells_of(places, grid):
    """Return the cells (n, 3) int64, by their indices along the axes, that hold `places` (n, 3)."""
    cells = np.empty((len(places), 3), np.int64)
    for p in range(len(places)):
        for axis in range(3):
            cells[p, axis] = _cell(grid, places[p, axis], axis)
    return cells


@kernel
def fill_bins(first, last, grid):
    """Return bins of boxes by their first and last cells (n, 3); a point's are the same."""
    shape = grid.shape
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    for f in range(len(first)):
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                row = (i * shape[1] + j) * shape[2]
                for k in range(first[f, 2], last[f, 2] + 1):
                    start[row + k] += 1
    for cell in range(1, len(start)):
        start[cell] += start[cell - 1]
    items = np.empty(start[-1], np.int64)
    for f in range(len(first) - 1, -1, -1):  # so that the ends of the cells come to be their starts
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                row = (i * shape[1] + j) * shape[2]
                for k in range(first[f, 2], last[f, 2] + 1):
                    start[row + k] -= 1
                    items[start[row + k]] = f
    return Bins(start, items, grid)


@lean_kernel
def cells_of_box(grid, lower, upper):
    """Return the first and last cell along each axis, in turn, of the box from lower (3,) to upper (3,).

    The items in cells (i, j, k0..k1) lie in one run, from that of the first cell to that of the last.
    """
    return (
        _cell(grid, lower[0], 0),
        _cell(grid, upper[0], 0),
        _cell(grid, lower[1], 1),
        _cell(grid, upper[1], 1),
        _cell(grid, lower[2], 2),
        _cell(grid, upper[2], 2),
    )
