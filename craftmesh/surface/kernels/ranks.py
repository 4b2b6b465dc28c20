"""Ranks of vertices: what the lines and the sheets that meet at each one leave it free to do."""

import numpy as np

from craftmesh.jit import kernel
from craftmesh.surface.kernels.corner_lists import corner_lists

# Ranks of vertices: a patch leaves two directions free, a line of feature edges one, a junction none.
IN_PATCH, ON_LINE, AT_JUNCTION = 0, 1, 2


@kernel
def line_ranks(facets, patch, number, count):
    """Return the ranks (count,) of vertices by the feature edges at each one.

    patch (m,): of the facets (m, 3); number (p,) uint64: of each patch, equal sums are equal patches.
    """
    first, after = corner_lists(facets, count)
    rank = np.empty(count, np.int64)
    seen = np.full(count, -1)
    for v in range(count):
        lines = 0
        sums = (np.uint64(0), np.uint64(0))
        c = first[v]
        while c >= 0:
            for i in range(1, 3):
                u = facets[c // 3, (c + i) % 3]
                if seen[u] == v:
                    continue
                seen[u] = v
                total = np.uint64(0)
                on_edge = 0
                alike = True
                d = c  # no corner before it has u
                while d >= 0:
                    g = d // 3
                    if facets[g, 0] == u or facets[g, 1] == u or facets[g, 2] == u:
                        total += number[patch[g]]
                        on_edge += 1
                        alike = alike and patch[g] == patch[c // 3]
                    d = after[d]
                if on_edge != 2 or not alike:
                    lines += 1
                    sums = (sums[1], total)
            c = after[c]
        rank[v] = AT_JUNCTION
        if lines == 0:
            rank[v] = IN_PATCH
        elif lines == 2 and sums[0] == sums[1]:
            rank[v] = ON_LINE
    return rank
