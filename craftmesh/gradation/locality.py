"""Spatial sorting of points and facets, and of the order of work, so that kernels use caches well."""

import numpy as np

from craftmesh.gradation.kernels.facet_order import rows_by_points, turned_to_least
from craftmesh.surface.measure import span_of
from craftmesh.surface.patches import oriented
from craftmesh.types import Surface

# Bits per axis of the Morton cells (2^10 cells along the longest extent), and number of successive vertex
# ids in a block of work.
CELL_BITS = 10
BLOCK = 2048


def spatially_sorted(surface: Surface) -> Surface:
    """Return `surface` oriented, with points sorted along a Morton curve and facets sorted by point ids.

    Points in one Morton cell, as wide as a 1023rd of the longest extent, are sorted by x, y and z. Each
    facet begins with its smallest id. So the result does not depend on the order of the input's points
    and facets, if no two points have the same coordinates.
    """
    keys = _morton_keys(surface.points)
    order = np.argsort(keys)
    ties = np.diff(keys[order]) == 0
    shared = np.flatnonzero(np.r_[False, ties] | np.r_[ties, False])
    tied = np.sort(order[shared])
    order[shared] = tied[np.lexsort((*surface.points[tied].T[::-1], keys[tied]))]
    new = np.empty_like(order)
    new[order] = np.arange(len(order))
    facets, sides = oriented(surface)
    facets = turned_to_least(np.require(facets, np.int32, ["C", "W"]), new)
    rows = rows_by_points(facets, len(order))
    points, kind = surface.points.take(order, axis=0), surface.kind[rows]
    return Surface(points, facets.take(rows, axis=0), sides.take(rows, axis=0), kind)


def block_order(vertices: np.ndarray, key: np.ndarray) -> np.ndarray:
    """Return the rows of `vertices` (e,) sorted by block of BLOCK ids, and in a block by ascending `key`.

    vertices (e,): one vertex of each item of work. Work on one block stays in the processor's cache.
    """
    block = vertices // BLOCK
    order = np.argsort(block, kind="stable")
    ends = np.cumsum(np.bincount(block))
    for start, end in zip(ends - np.diff(ends, prepend=0), ends):
        rows = order[start:end]
        order[start:end] = rows[np.argsort(key[rows], kind="stable")]
    return order


def _morton_keys(points: np.ndarray) -> np.ndarray:
    low, high = span_of(points)
    extent = max(float((high - low).max()), np.finfo(float).tiny)
    cells = ((points - low) * ((2**CELL_BITS - 1) / extent)).astype(np.int64)
    keys = np.zeros(len(points), np.int64)
    for bit in range(CELL_BITS):
        for axis in range(3):
            keys |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return keys
