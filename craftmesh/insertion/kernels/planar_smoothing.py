"""Smoothing of planar triangulations."""

import numpy as np

from craftmesh.insertion.kernels.planar import squared_distance, turn
from craftmesh.jit import lean_kernel

TWICE_ROOT_3 = 2.0 * np.sqrt(3.0)
GOOD = 0.6  # a point moves even where its worst triangle loses, if that stays above this


@lean_kernel
def shape(uv, a, b, c):
    """4 sqrt(3) area over the sum of the squared edges: 1 for even ones, negative where turned over."""
    area = turn(uv, a, b, c)
    edges = squared_distance(uv, a, b) + squared_distance(uv, b, c) + squared_distance(uv, c, a)
    return TWICE_ROOT_3 * area / edges


@lean_kernel
def _worst_shape(uv, corners, around):
    """The least shape of the triangles `around`."""
    worst = np.inf
    for t in around:
        worst = min(worst, shape(uv, corners[t, 0], corners[t, 1], corners[t, 2]))
    return worst


@lean_kernel
def smooth_in_plane(uv, corners, start, owner, movable):
    """Move points to the area-weighted centroid of their triangles where their worst triangle allows.

    start (n + 1,), owner: the triangles around each point in compressed rows; movable: points to move.
    """
    for point in movable:
        around = owner[start[point] : start[point + 1]]
        before = _worst_shape(uv, corners, around)
        area, u, v = 0.0, 0.0, 0.0
        for t in around:
            a, b, c = corners[t]
            weight = turn(uv, a, b, c)
            area += weight
            u += weight * (uv[a, 0] + uv[b, 0] + uv[c, 0]) / 3
            v += weight * (uv[a, 1] + uv[b, 1] + uv[c, 1]) / 3
        if area <= 0.0:
            continue
        old_u, old_v = uv[point, 0], uv[point, 1]
        uv[point, 0], uv[point, 1] = u / area, v / area
        after = _worst_shape(uv, corners, around)
        if after < before and after < GOOD:
            uv[point, 0], uv[point, 1] = old_u, old_v
