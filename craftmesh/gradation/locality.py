"""Order in memory and of work: what is near in space is near in both, so that caches serve the kernels."""

import numpy as np

from craftmesh.types import Surface

# Bits per axis of the cells along whose curve the points are sorted, and vertices per block of work.
CELL_BITS = 10
BLOCK = 2048


def spatially_sorted(surface: Surface) -> Surface:
    """Return `surface` with points along a Morton curve through the box and facets by their points.

    Points of one cell, a 1024th of the longest extent, go by x, y and z, and facets begin with their least
    point: the order of the input, in which ties are broken, does not matter.
    """
    order = np.lexsort((*surface.points.T[::-1], _morton_keys(surface.points)))
    new = np.empty(len(order), surface.facets.dtype)
    new[order] = np.arange(len(order), dtype=new.dtype)
    facets = new[surface.facets]
    turns = np.argmin(facets, axis=1)[:, None] + np.arange(3)
    facets = np.take_along_axis(facets, turns % 3, axis=1)
    rows = np.lexsort(np.sort(facets, axis=1).T[::-1])
    return Surface(surface.points[order], facets[rows], surface.sides[rows], surface.kind[rows])


def block_order(edges: np.ndarray, key: np.ndarray) -> np.ndarray:
    """Return the rows of `edges` (e, 2) block by block of vertices, in each by ascending `key` (e,)."""
    block = edges[:, 0] // BLOCK
    order = np.argsort(block, kind="stable")
    ends = np.cumsum(np.bincount(block))
    for start, end in zip(ends - np.diff(ends, prepend=0), ends):
        rows = order[start:end]
        order[start:end] = rows[np.argsort(key[rows], kind="stable")]
    return order


def _morton_keys(points: np.ndarray) -> np.ndarray:
    low = points.min(axis=0, initial=np.inf)
    extent = max(float((points - low).max(initial=0.0)), np.finfo(float).tiny)
    cells = ((points - low) * ((2**CELL_BITS - 1) / extent)).astype(np.int64)
    keys = np.zeros(len(points), np.int64)
    for bit in range(CELL_BITS):
        for axis in range(3):
            keys |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return keys
