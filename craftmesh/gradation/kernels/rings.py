"""Who meets round an edge, by corner lists: facets, features, all edges."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel


@lean_kernel
def has_corner(facets, f, v):
    """Tell whether `v` is a corner of facet `f`."""
    return facets[f, 0] == v or facets[f, 1] == v or facets[f, 2] == v


@lean_kernel
def third_corner(facets, f, a, b):
    """Return the corner of facet `f` that is neither `a` nor `b`."""
    return facets[f, 0] + facets[f, 1] + facets[f, 2] - a - b


@lean_kernel
def edge_facets(facets, first, after, a, b):
    """Return the number of facets on edge (a, b) and the first two of them (-1 where missing)."""
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
    """Tell whether edge (a, b) is a feature: not two facets on it, or two of different patches."""
    count, f0, f1 = edge_facets(facets, first, after, a, b)
    return count != 2 or patch[f0] != patch[f1]


@kernel
def list_edges(facets, patch, first, after, rank, vertex_count, facet_count, stamp, clock):
    """Return all edges (e, 2), lower vertex first, and whether each is a feature (e,)."""
    edges = np.empty((3 * facet_count, 2), np.int64)
    feature = np.empty(3 * facet_count, np.bool_)
    count = 0
    for v in range(vertex_count):
        clock[0] += 1
        c = first[v]
        while c >= 0:
            f = c // 3
            for i in range(1, 3):
                u = facets[f, (c + i) % 3]
                if u > v and stamp[u] != clock[0]:
                    stamp[u] = clock[0]
                    edges[count, 0] = v
                    edges[count, 1] = u
                    feature[count] = (
                        rank[v] > 0 and rank[u] > 0 and is_feature(facets, patch, first, after, v, u)
                    )
                    count += 1
            c = after[c]
    return edges[:count].copy(), feature[:count].copy()
