"""Kernels that find the label at a position from the facets above it."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector

# Most labels that are counted above one place; further ones are ignored.
MAX_LABELS = 64


@lean_kernel
def _turn(points, a, b, x, y):
    """Return on which side, 1 or -1, of (x, y) the line a-b passes, seen along z.

    Both facets of an edge agree on it, also if the line passes through (x, y).
    """
    sign = 1.0
    if a > b:
        a, b = b, a
        sign = -1.0
    cross = (points[b, 0] - points[a, 0]) * (y - points[a, 1])
    cross -= (points[b, 1] - points[a, 1]) * (x - points[a, 0])
    return sign if cross >= 0.0 else -sign


@lean_kernel
def _is_below(points, facets, f, x, y, z):
    """Return 1 or -1 if facet f lies straight above the place (x, y, z) and faces up or down, else 0."""
    a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
    turn = _turn(points, a, b, x, y)
    if turn != _turn(points, b, c, x, y) or turn != _turn(points, c, a, x, y):
        return 0.0
    nx, ny, nz = area_vector(points, a, b, c)
    height = (x - points[a, 0]) * nx + (y - points[a, 1]) * ny + (z - points[a, 2]) * nz
    return turn if height * turn < 0.0 else 0.0


@lean_kernel
def _count(label, change, found, times, total):
    """Add `change` to the count of a label; return the number of labels found so far.

    found, times: labels and their counts, of which `total` are in use. Labels over MAX_LABELS are ignored.
    """
    for i in range(total):
        if found[i] == label:
            times[i] += change
            return total
    if total < MAX_LABELS:
        found[total] = label
        times[total] = change
        return total + 1
    return total


@kernel
def winding_labels(places, bins, points, facets, sides):
    """Return the label (q,) with the largest winding number at each place; 0 if none is positive.

    bins: of the facets (m, 3), over x and y only.
    """
    low, width, shape = bins.grid.low, bins.grid.width, bins.grid.shape
    result = np.zeros(len(places), np.int64)
    found, times = np.empty(MAX_LABELS, np.int64), np.empty(MAX_LABELS)
    for q in range(len(places)):
        x, y, z = places[q, 0], places[q, 1], places[q, 2]
        i, j = int(np.floor((x - low[0]) / width)), int(np.floor((y - low[1]) / width))
        if i < 0 or j < 0 or i >= shape[0] or j >= shape[1]:
            continue
        total = 0
        for k in range(bins.start[i * shape[1] + j], bins.start[i * shape[1] + j + 1]):
            f = bins.items[k]
            turn = _is_below(points, facets, f, x, y, z)
            if turn != 0.0:
                total = _count(sides[f, 0], turn, found, times, total)
                total = _count(sides[f, 1], -turn, found, times, total)
        best = 0.5
        for k in range(total):
            if found[k] != 0 and times[k] > best:
                best = times[k]
                result[q] = found[k]
    return result
