"""The search for all pairs of intersecting triangles, through the cells of a grid."""

import numpy as np
from numba import njit

from craftmesh.surface.kernels.triangles import triangles_intersect


@njit(cache=True)
def _bounds(points, facets):
    low, high = np.empty((len(facets), 3)), np.empty((len(facets), 3))
    for f in range(len(facets)):
        for k in range(3):
            a, b, c = points[facets[f, 0], k], points[facets[f, 1], k], points[facets[f, 2], k]
            low[f, k] = min(a, b, c)
            high[f, k] = max(a, b, c)
    return low, high


@njit(cache=True)
def _fill_grid(first, last, shape):
    """Compressed rows: the facets of each grid cell, in ascending order."""
    count = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    for f in range(len(first)):
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                row = (i * shape[1] + j) * shape[2]
                for k in range(first[f, 2], last[f, 2] + 1):
                    count[row + k + 1] += 1
    start = np.cumsum(count)
    free = start[:-1].copy()
    items = np.empty(start[-1], np.int64)
    for f in range(len(first)):
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                row = (i * shape[1] + j) * shape[2]
                for k in range(first[f, 2], last[f, 2] + 1):
                    items[free[row + k]] = f
                    free[row + k] += 1
    return start, items


@njit(cache=True)
def _bounds_meet_in_cell(low, high, first, f, g, cell):
    """Whether the facets' bounds meet and the lower corner of what they share lies in this cell."""
    for k in range(3):
        if low[f, k] > high[g, k] or low[g, k] > high[f, k] or max(first[f, k], first[g, k]) != cell[k]:
            return False
    return True


@njit(cache=True)
def _pairs_in_cell(points, facets, low, high, first, cell, items, pairs, found):
    """Append the intersecting pairs whose common bounds begin in this cell."""
    for x in range(len(items)):
        f = items[x]
        for y in range(x + 1, len(items)):
            g = items[y]
            if not _bounds_meet_in_cell(low, high, first, f, g, cell):
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


@njit(cache=True)
def _search(points, facets, low, high, first, last, shape, limit):
    start, items = _fill_grid(first, last, shape)
    pairs = np.empty((limit, 2), np.int64)
    found = 0
    cell = np.empty(3, np.int64)
    for c in range(len(start) - 1):
        if start[c + 1] - start[c] > 1:
            cell[0] = c // (shape[1] * shape[2])
            cell[1] = c // shape[2] % shape[1]
            cell[2] = c % shape[2]
            found = _pairs_in_cell(
                points, facets, low, high, first, cell, items[start[c] : start[c + 1]], pairs, found
            )
            if found == limit:
                break
    return pairs[:found].copy()


def intersecting_pairs(points: np.ndarray, facets: np.ndarray, limit: int = 100_000) -> np.ndarray:
    """Return the pairs (k, 2) int64 of `facets` (m, 3) that meet in more than their shared vertices.

    Pairs come sorted, lower facet first. The search ends after `limit` pairs.
    """
    facets = np.ascontiguousarray(facets, np.int64)
    points = np.array(points, np.float64, order="C")  # read-only arrays would be compiled for anew
    if len(facets) < 2:
        return np.zeros((0, 2), np.int64)
    low, high = _bounds(points, facets)
    extent = (high - low).max(axis=1)
    span = high.max(axis=0) - low.min(axis=0)
    cell = max(float(np.median(extent)), float(extent.mean()) / 2, 1e-300)
    most = 8 * len(facets) + 1000
    while np.prod(np.floor(span / cell) + 1) > most:
        cell *= 1.25
    origin = low.min(axis=0)
    first = ((low - origin) / cell).astype(np.int64)
    last = ((high - origin) / cell).astype(np.int64)
    shape = last.max(axis=0) + 1
    pairs = _search(points, facets, low, high, first, last, shape, int(limit))
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
