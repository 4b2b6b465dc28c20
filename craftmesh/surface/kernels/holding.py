"""Find the triangle of a plane triangulation that contains a point."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.bins import Bins, cells_of, fill_bins, grid_over
from craftmesh.surface.rounding import EXACT


def bins_of(nodes: np.ndarray, triangles: np.ndarray) -> Bins:
    """Return bins of the triangles (m, 3) on nodes (n, 2), with about one triangle per bin."""
    flat = np.column_stack([nodes, np.zeros(len(nodes))])
    corners = flat[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    extent = np.ptp(nodes, axis=0)
    width = max(np.sqrt(extent[0] * extent[1] / len(triangles)), 1e-3 * extent.max())
    grid = grid_over(low.min(axis=0), high.max(axis=0), width)
    return fill_bins(cells_of(low, grid), cells_of(high, grid), grid)


@kernel
def holding(uv, nodes, triangles, bins):
    """Return the id (k,) of the first of the triangles (m, 3) on nodes (n, 2) that contains each point.

    It is -1 if none does. uv (k, 2): the points; bins: of the triangles, from `bins_of`.
    """
    found = np.full(len(uv), -1)
    grid = bins.grid
    for p in range(len(uv)):
        i = int(np.floor((uv[p, 0] - grid.low[0]) / grid.width))
        j = int(np.floor((uv[p, 1] - grid.low[1]) / grid.width))
        if i < 0 or j < 0 or i >= grid.shape[0] or j >= grid.shape[1]:
            continue
        cell = i * grid.shape[1] + j
        for item in range(bins.start[cell], bins.start[cell + 1]):
            t = bins.items[item]
            if _holds(nodes, triangles[t, 0], triangles[t, 1], triangles[t, 2], uv[p, 0], uv[p, 1]):
                found[p] = t
                break
    return found


@lean_kernel
def _holds(nodes, a, b, c, u, v):
    """Return whether the triangle a, b, c, in either orientation, contains the point u, v."""
    bu, bv = nodes[b, 0] - nodes[a, 0], nodes[b, 1] - nodes[a, 1]
    cu, cv = nodes[c, 0] - nodes[a, 0], nodes[c, 1] - nodes[a, 1]
    u, v = u - nodes[a, 0], v - nodes[a, 1]
    twice = bu * cv - bv * cu
    s, t = u * cv - v * cu, bu * v - bv * u
    if twice < 0.0:
        twice, s, t = -twice, -s, -t
    slack = -EXACT * twice
    return s >= slack and t >= slack and twice - s - t >= slack
