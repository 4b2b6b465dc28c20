"""The search for facets that a move of the vertices has spoiled."""

import numpy as np

from craftmesh.jit import kernel


@kernel
def _shape(points, a, b, c):
    """Quality of a triangle (1 equilateral, 0 flat) and its shortest edge squared."""
    squares, shortest = 0.0, np.inf
    for p, q in ((a, b), (b, c), (c, a)):
        square = 0.0
        for axis in range(3):
            square += (points[q, axis] - points[p, axis]) ** 2
        squares += square
        shortest = min(shortest, square)
    ux, uy, uz = points[b] - points[a]
    vx, vy, vz = points[c] - points[a]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    if squares == 0.0:
        return 0.0, 0.0
    return 2.0 * np.sqrt(3.0) * np.sqrt(nx * nx + ny * ny + nz * nz) / squares, shortest


@kernel
def spoiled_facets(points, before, facets, min_quality, min_edge):
    """(m,) bool: facets worse than at the points `before`, and of low quality or with a short edge.

    Quality is 4 sqrt(3) area / sum of squared edges; min_edge is a length.
    """
    spoiled = np.zeros(len(facets), np.bool_)
    for f in range(len(facets)):
        a, b, c = facets[f]
        quality, edge = _shape(points, a, b, c)
        if quality < min_quality or edge < min_edge * min_edge:
            old_quality, old_edge = _shape(before, a, b, c)
            spoiled[f] = quality < old_quality if quality < min_quality else edge < old_edge
    return spoiled
