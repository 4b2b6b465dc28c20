"""The search for all pairs of intersecting triangles, through the cells of a grid."""

from collections import namedtuple

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.bins import cells_of, fill_bins, grid_over
from craftmesh.surface.kernels.triangles import triangles_intersect

# Facets (m, 3) on points, their bounds (m, 3), the cells (m, 3) of their lower bounds, and whether pairs
# with them are looked for (m,).
BoundedFacets = namedtuple("BoundedFacets", "points facets low high first chosen")
# Cells of the grid: at most so many a facet, and so many more.
CELLS_PER_FACET, MORE_CELLS = 8, 1000
# Cells grow by this factor until they are few enough.
WIDER = 1.25


@kernel
def _bounds(points, facets):
    """Return the bounds (m, 3) of facets, their largest extents (m,), and the bounds (3,) of all."""
    low, high = np.empty((len(facets), 3)), np.empty((len(facets), 3))
    extent, least, most = np.zeros(len(facets)), np.full(3, np.inf), np.full(3, -np.inf)
    for f in range(len(facets)):
        for k in range(3):
            a, b, c = points[facets[f, 0], k], points[facets[f, 1], k], points[facets[f, 2], k]
            low[f, k] = min(a, b, c)
            high[f, k] = max(a, b, c)
            extent[f] = max(extent[f], high[f, k] - low[f, k])
            least[k] = min(least[k], low[f, k])
            most[k] = max(most[k], high[f, k])
    return low, high, extent, least, most


@lean_kernel
def _bounds_meet_in_cell(bounded, f, g, cell):
    """Whether the facets' bounds meet and the lower corner of what they share lies in this cell."""
    low, high, first = bounded.low, bounded.high, bounded.first
    for k in range(3):
        if low[f, k] > high[g, k] or low[g, k] > high[f, k] or max(first[f, k], first[g, k]) != cell[k]:
            return False
    return True


@lean_kernel
def _pairs_in_cell(bounded, items, cell, pairs, found):
    """Append the intersecting pairs whose common bounds begin in this cell; return how many there are."""
    points, facets, chosen = bounded.points, bounded.facets, bounded.chosen
    for x in range(len(items)):
        f = items[x]
        for y in range(x + 1, len(items)):
            g = items[y]
            if not (chosen[f] or chosen[g]) or not _bounds_meet_in_cell(bounded, f, g, cell):
                continue
            if triangles_intersect(
                points, facets[f, 0], facets[f, 1], facets[f, 2], facets[g, 0], facets[g, 1], facets[g, 2]
            ):
                if found == len(pairs):
                    return found
                pairs[found, 0] = f
                pairs[found, 1] = g
                found += 1
    return found


@lean_kernel
def _has_chosen(chosen, items, start, end):
    for n in range(start, end):
        if chosen[items[n]]:
            return True
    return False


@kernel
def _search(bounded, bins, limit):
    start, items, shape = bins.start, bins.items, bins.grid.shape
    pairs = np.empty((limit, 2), np.int64)
    found = 0
    cell = np.empty(3, np.int64)
    for c in range(len(start) - 1):
        if start[c + 1] - start[c] > 1 and _has_chosen(bounded.chosen, items, start[c], start[c + 1]):
            cell[0] = c // (shape[1] * shape[2])
            cell[1] = c // shape[2] % shape[1]
            cell[2] = c % shape[2]
            found = _pairs_in_cell(bounded, items[start[c] : start[c + 1]], cell, pairs, found)
            if found == limit:
                break
    return pairs[:found].copy()


def intersecting_pairs(
    points: np.ndarray, facets: np.ndarray, limit: int = 100_000, chosen: np.ndarray | None = None
) -> np.ndarray:
    """Return the pairs (k, 2) int64 of `facets` (m, 3) that meet in more than their shared vertices.

    Pairs come sorted, lower facet first. The search ends after `limit` pairs. chosen (m,) bool: only pairs
    with one of these facets are looked for.
    """
    facets = np.ascontiguousarray(facets, np.int64)
    points = np.array(points, np.float64, order="C")  # read-only arrays would be compiled for anew
    if len(facets) < 2:
        return np.zeros((0, 2), np.int64)
    low, high, extent, least, most = _bounds(points, facets)
    width = max(float(np.median(extent)), float(extent.mean()) / 2, 1e-300)
    while np.prod(np.floor((most - least) / width) + 1) > CELLS_PER_FACET * len(facets) + MORE_CELLS:
        width *= WIDER
    grid = grid_over(least, most, width)
    first = cells_of(low, grid)
    bins = fill_bins(first, cells_of(high, grid), grid)
    chosen = np.ones(len(facets), bool) if chosen is None else chosen
    pairs = _search(BoundedFacets(points, facets, low, high, first, chosen), bins, int(limit))
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
