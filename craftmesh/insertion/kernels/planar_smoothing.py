"""Smoothing of planar triangulations."""

import numpy as np
from numba import njit

from craftmesh.insertion.kernels.planar import square, turn


@njit(cache=True)
def _quality(uv, a, b, c):
    area = turn(uv, a, b, c)
    return 3.4641016151377544 * area / (square(uv, a, b) + square(uv, b, c) + square(uv, c, a))


@njit(cache=True)
def smooth(uv, corners, start, owner, movable):
    """Move points to the area-weighted centroid of their triangles where their worst triangle gains.

    start (n + 1,), owner: the triangles around each point in compressed rows; movable: points to move.
    """
    for point in movable:
        before, area, u, v = np.inf, 0.0, 0.0, 0.0
        for k in range(start[point], start[point + 1]):
            a, b, c = corners[owner[k]]
            before = min(before, _quality(uv, a, b, c))
            weight = turn(uv, a, b, c)
            area += weight
            u += weight * (uv[a, 0] + uv[b, 0] + uv[c, 0]) / 3
            v += weight * (uv[a, 1] + uv[b, 1] + uv[c, 1]) / 3
        old_u, old_v = uv[point, 0], uv[point, 1]
        if area <= 0.0:
            continue
        uv[point, 0], uv[point, 1] = u / area, v / area
        after = np.inf
        for k in range(start[point], start[point + 1]):
            a, b, c = corners[owner[k]]
            after = min(after, _quality(uv, a, b, c))
        if after < before and after < 0.6:
            uv[point, 0], uv[point, 1] = old_u, old_v
