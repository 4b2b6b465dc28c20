"""Kernels that tell which label a place has, by the facets above it."""

import numpy as np
from numba import njit

from craftmesh.surface.kernels.facet_shape import area_vector

MAX_LABELS = 64


@njit(cache=True)
def bin_facets(points, facets, low, width, shape):
    """Return (start, items): the facets over cell c of a grid in x, y are items[start[c]:start[c + 1]]."""
    first, last = np.empty((len(facets), 2), np.int64), np.empty((len(facets), 2), np.int64)
    start = np.zeros(shape[0] * shape[1] + 1, np.int64)
    for f in range(len(facets)):
        for k in range(2):
            a, b, c = points[facets[f, 0], k], points[facets[f, 1], k], points[facets[f, 2], k]
            first[f, k] = min(max(int((min(a, b, c) - low[k]) / width), 0), shape[k] - 1)
            last[f, k] = min(max(int((max(a, b, c) - low[k]) / width), 0), shape[k] - 1)
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                start[i * shape[1] + j + 1] += 1
    start = np.cumsum(start)
    free = start[:-1].copy()
    items = np.empty(start[-1], np.int64)
    for f in range(len(facets)):
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                items[free[i * shape[1] + j]] = f
                free[i * shape[1] + j] += 1
    return start, items


@njit(cache=True)
def _turn(points, a, b, x, y):
    """Return the side of (x, y) on which the line from a to b passes; facets on both sides of it agree."""
    sign = 1.0
    if a > b:
        a, b = b, a
        sign = -1.0
    cross = (points[b, 0] - points[a, 0]) * (y - points[a, 1])
    cross -= (points[b, 1] - points[a, 1]) * (x - points[a, 0])
    return sign if cross >= 0.0 else -sign


@njit(cache=True)
def _is_below(points, facets, f, x, y, z):
    """Return 1 or -1 when facet f, looking up or down, lies straight above the place; else 0."""
    a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
    turn = _turn(points, a, b, x, y)
    if turn != _turn(points, b, c, x, y) or turn != _turn(points, c, a, x, y):
        return 0.0
    nx, ny, nz = area_vector(points, a, b, c)
    height = (x - points[a, 0]) * nx + (y - points[a, 1]) * ny + (z - points[a, 2]) * nz
    return turn if height * turn < 0.0 else 0.0


@njit(cache=True)
def _count(label, change, found, times, total):
    for i in range(total):
        if found[i] == label:
            times[i] += change
            return total
    if total < MAX_LABELS:
        found[total] = label
        times[total] = change
        return total + 1
    return total


@njit(cache=True)
def winding_labels(places, start, items, low, width, shape, points, facets, sides):
    """Return the label (q,) with the largest winding number round each place; 0 where none is positive."""
    result = np.zeros(len(places), np.int64)
    found, times = np.empty(MAX_LABELS, np.int64), np.empty(MAX_LABELS)
    for q in range(len(places)):
        x, y, z = places[q, 0], places[q, 1], places[q, 2]
        i, j = int(np.floor((x - low[0]) / width)), int(np.floor((y - low[1]) / width))
        if i < 0 or j < 0 or i >= shape[0] or j >= shape[1]:
            continue
        total = 0
        for k in range(start[i * shape[1] + j], start[i * shape[1] + j + 1]):
            f = items[k]
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
