"""Who meets at a vertex and round an edge, by corner lists: features, ranks of vertices, edges."""

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


@lean_kernel
def _edge_signature(facets, patch, first, after, a, b):
    """Return whether (a, b) is a feature and a number that is the same for the same set of patches."""
    count = 0
    signature = np.uint64(0)
    same = True
    last = -1
    c = first[a]
    while c >= 0:
        f = c // 3
        if has_corner(facets, f, b):
            mixed = np.uint64(patch[f] + 1) * np.uint64(0x9E3779B97F4A7C15)
            mixed ^= mixed >> np.uint64(29)
            signature += mixed * np.uint64(0xBF58476D1CE4E5B9)
            same = same and (count == 0 or patch[f] == last)
            last = patch[f]
            count += 1
        c = after[c]
    return count != 2 or not same, signature


@lean_kernel
def _is_tied(facets, first, after, stamp, mark, v):
    """Tell whether the facets at `v` fall into groups that meet in `v` alone."""
    start = first[v] // 3
    for i in range(3):
        stamp[facets[start, i]] = mark
    grown = True
    whole = False
    while grown:
        grown = False
        whole = True
        c = first[v]
        while c >= 0:
            f = c // 3
            p = facets[f, (c + 1) % 3]
            q = facets[f, (c + 2) % 3]
            if (stamp[p] == mark) != (stamp[q] == mark):
                stamp[p] = mark
                stamp[q] = mark
                grown = True
            elif stamp[p] != mark:
                whole = False
            c = after[c]
    return not whole


@lean_kernel
def classify(facets, patch, first, after, vertex_count, rank, stamp, clock):
    """Set `rank`: 0 inside a patch, 1 on a feature line, 2 a feature point (fixed).

    A line vertex has exactly two feature edges with the same patches round them; vertices whose
    facets fall into groups that meet in them alone are points.
    """
    for v in range(vertex_count):
        rank[v] = 0
        if first[v] < 0:
            continue
        clock[0] += 1
        features = 0
        kept = np.uint64(0)
        same = True
        c = first[v]
        while c >= 0:
            f = c // 3
            for i in range(1, 3):
                u = facets[f, (c + i) % 3]
                if stamp[u] != clock[0]:
                    stamp[u] = clock[0]
                    feature, signature = _edge_signature(facets, patch, first, after, v, u)
                    if feature:
                        same = same and (features == 0 or signature == kept)
                        kept = signature
                        features += 1
            c = after[c]
        if features == 2 and same:
            rank[v] = 1
        elif features > 0:
            rank[v] = 2
        clock[0] += 1
        if rank[v] < 2 and _is_tied(facets, first, after, stamp, clock[0], v):
            rank[v] = 2


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
