"""Facets on an edge, feature edges and lists of edges, from corner lists."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import squared_distance


@lean_kernel
def has_corner(facets, f, v):
    """Return whether `v` is a corner of facet `f`."""
    return facets[f, 0] == v or facets[f, 1] == v or facets[f, 2] == v


@lean_kernel
def third_corner(facets, f, a, b):
    """Return the corner of facet `f` that is neither `a` nor `b`."""
    return facets[f, 0] + facets[f, 1] + facets[f, 2] - a - b


@lean_kernel
def edge_facets(facets, first, after, a, b):
    """Return the number of facets on edge (a, b) and the first two of them, -1 if missing."""
    count = 0
    f0 = -1
    f1 = -1
    c = first[a]
    while c >= 0:
        f = c // 3
        if has_corner(facets, f, b):
            if count == 0:
                f0 = f
            elif count == 1:
                f1 = f
            count += 1
        c = after[c]
    return count, f0, f1


@lean_kernel
def is_feature(facets, patch, first, after, a, b):
    """Return whether edge (a, b) is a feature edge, as on junction lines.

    It is one if it does not have exactly two facets, or if its two facets have different patches.
    """
    count, f0, f1 = edge_facets(facets, first, after, a, b)
    return count != 2 or patch[f0] != patch[f1]


@kernel
def list_edges(state, least, most):
    """Return edges (e, 2), a mask (e,) of feature edges, and ratios (e,) of length to target length.

    Only edges with a ratio strictly between `least` and `most` are returned, lower vertex first.
    """
    # where closed grains fill a body, edges are fewer than vertices and facets together
    count = state.used[0] + state.used[1]
    room = np.int64(0)
    while count > room:
        room = count
        edges = np.empty((room, 2), np.int64)
        feature = np.empty(room, np.bool_)
        ratio = np.empty(room)
        count = _walk_edges(state, least, most, edges, feature, ratio)
    return edges[:count], feature[:count], ratio[:count]


@lean_kernel
def _walk_edges(state, least, most, edges, feature, ratio):
    """Fill the arrays of `list_edges` as far as they reach; return the number of edges they should hold."""
    facets, first, after, rank, size, stamp = (
        state.facets,
        state.first,
        state.after,
        state.rank,
        state.size,
        state.stamp,
    )
    count = 0
    for v in range(state.used[0]):
        state.clock[0] += 1
        c = first[v]
        while c >= 0:
            f = c // 3
            for i in range(1, 3):
                u = facets[f, (c + i) % 3]
                if u > v and stamp[u] != state.clock[0]:
                    stamp[u] = state.clock[0]
                    times = np.sqrt(squared_distance(state.points, v, u)) / (0.5 * (size[v] + size[u]))
                    if not least < times < most:
                        continue
                    if count < len(edges):
                        edges[count, 0] = v
                        edges[count, 1] = u
                        ratio[count] = times
                        lines = rank[v] > 0 and rank[u] > 0
                        feature[count] = lines and is_feature(facets, state.patch, first, after, v, u)
                    count += 1
            c = after[c]
    return count
