"""Gradients of the grains' volumes by the positions of points, and areas and edges around points."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector, squared_distance


@kernel
def around_points(points, facets, lists):
    """Return a third of the facets' area (n,) at each point, and the mean length (n,) of its edges."""
    area, edge = np.zeros(len(points)), np.zeros(len(points))
    for v in range(len(points)):
        count, corner = 0, lists[0][v]
        while corner >= 0:
            f, k = corner // 3, corner % 3
            x, y, z = area_vector(points, facets[f, 0], facets[f, 1], facets[f, 2])
            area[v] += np.sqrt(x * x + y * y + z * z) / 6.0
            for step in range(1, 3):
                edge[v] += np.sqrt(squared_distance(points, v, facets[f, (k + step) % 3]))
                count += 1
            corner = lists[1][corner]
        edge[v] /= max(count, 1)
    return area, edge


@lean_kernel
def _add(rows, vectors, first, end, row, x, y, z):
    """Add (x, y, z) to the vector of `row`, which is appended if not in first..end; return the new end."""
    at = first
    while at < end and rows[at] != row:
        at += 1
    if at == end:
        rows[at] = row
        vectors[at] = 0.0
    vectors[at, 0] += x
    vectors[at, 1] += y
    vectors[at, 2] += z
    return max(end, at + 1)


@kernel
def volume_gradients(points, facets, lists, grains):
    """Return start (n + 1,), rows (k,) of grains, and gradients (k, 3) of their volumes by point positions.

    Point v has the rows and gradients from start[v] to start[v + 1]. grains (m, 2): the rows of the grains
    behind and ahead of each facet, -1 for none; lists: the facets' corner lists.
    """
    start = np.zeros(len(points) + 1, np.int32)
    rows, vectors = np.empty(4 * len(points), np.int32), np.empty((4 * len(points), 3))
    for v in range(len(points)):
        most, corner = start[v], lists[0][v]
        while corner >= 0:
            most += 2
            corner = lists[1][corner]
        if most > len(rows):
            rows = np.concatenate((rows, np.empty(most, np.int32)))
            vectors = np.concatenate((vectors, np.empty((most, 3))))
        end, corner = start[v], lists[0][v]
        while corner >= 0:
            f = corner // 3
            x, y, z = area_vector(points, facets[f, 0], facets[f, 1], facets[f, 2])
            for side in range(2):
                if grains[f, side] >= 0:
                    part = (1 - 2 * side) / 6.0
                    end = _add(rows, vectors, start[v], end, grains[f, side], part * x, part * y, part * z)
            corner = lists[1][corner]
        start[v + 1] = end
    return start, rows[: start[-1]], vectors[: start[-1]]
