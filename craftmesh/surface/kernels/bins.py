"""Bins: which points or boxes lie in each cell of a regular grid, for searches of neighbours."""

from collections import namedtuple

import numpy as np

from craftmesh.jit import kernel, lean_kernel

# Grid of cubic cells: lowest corner `low` (3,), edge `width`, number of cells `shape` (3,). Points outside
# the grid belong to its outermost cells.
Grid = namedtuple("Grid", "low width shape")
# Items of cell c: items[start[c] : start[c + 1]], ascending. Cells are numbered along the last axis first.
Bins = namedtuple("Bins", "start items grid")


def grid_over(low: np.ndarray, high: np.ndarray, width: float) -> Grid:
    """Return the grid of cells with edge `width` over the box from `low` (3,) to `high` (3,)."""
    return Grid(np.array(low, float), float(width), ((high - low) / width).astype(np.int64) + 1)


@lean_kernel
def cell_along(grid, x, axis):
    """Return the index along an axis, 0 to 2, of the cell that holds the coordinate x.

    Outside the grid it is the first or last cell.
    """
    return min(max(int((x - grid.low[axis]) / grid.width), 0), grid.shape[axis] - 1)


@kernel
def cells_of(places, grid):
    """Return cell indices (n, 3) int64 along the axes of `places` (n, 3)."""
    cells = np.empty((len(places), 3), np.int64)
    for p in range(len(places)):
        for axis in range(3):
            cells[p, axis] = cell_along(grid, places[p, axis], axis)
    return cells


@kernel
def fill_bins(first, last, grid):
    """Return the bins, which list the boxes in each cell.

    Box i extends from cell first[i] to cell last[i], rows of (n, 3) arrays; they are equal for points.
    """
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
    for f in range(len(first) - 1, -1, -1):  # backwards: each start[cell] counts down from the cell's end
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                row = (i * shape[1] + j) * shape[2]
                for k in range(first[f, 2], last[f, 2] + 1):
                    start[row + k] -= 1
                    items[start[row + k]] = f
    return Bins(start, items, grid)


@lean_kernel
def cells_of_box(grid, lower, upper):
    """Return first and last cell along x, y and z, in this order, of the box from `lower` to `upper` (3,).

    Items in cells (i, j, k0..k1) are contiguous, from the start of the first cell to the end of the last.
    """
    return (
        cell_along(grid, lower[0], 0),
        cell_along(grid, upper[0], 0),
        cell_along(grid, lower[1], 1),
        cell_along(grid, upper[1], 1),
        cell_along(grid, lower[2], 2),
        cell_along(grid, upper[2], 2),
    )
