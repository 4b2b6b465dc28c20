"""Non-manifold vertices (tied nodes): vertices where parts of the surface meet without a common edge."""

import numpy as np

from craftmesh.jit import kernel
from craftmesh.surface.kernels.corner_lists import corner_lists


@kernel
def tied_vertices(facets, count):
    """Return a mask (count,) of vertices whose facets (m, 3) form groups that share no edge there."""
    first, after = corner_lists(facets, count)
    tied = np.zeros(count, np.bool_)
    reached = np.full(count, -1)  # last vertex v from whose first facet each vertex was reached
    for v in range(count):
        reached[v] = v
        grown = first[v] >= 0
        if grown:
            for i in range(1, 3):
                reached[facets[first[v] // 3, (first[v] + i) % 3]] = v
        while grown:
            grown = False
            tied[v] = False
            c = first[v]
            while c >= 0:
                p = facets[c // 3, (c + 1) % 3]
                q = facets[c // 3, (c + 2) % 3]
                if (reached[p] == v) != (reached[q] == v):
                    reached[p] = v
                    reached[q] = v
                    grown = True
                elif reached[p] != v:
                    tied[v] = True
                c = after[c]
    return tied
