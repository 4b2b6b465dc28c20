"""Corner lists: the facets at each vertex, as one linked list of corners per vertex.

Corner c belongs to facet c // 3 and to vertex facets[c // 3, c % 3]. `first[v]` is the first corner at v
and `after[c]` the next one, -1 at the end. Non-manifold edges need no special treatment.
"""

import numpy as np

from craftmesh.jit import kernel, lean_kernel


@lean_kernel
def link_corner(first, after, vertex, corner):
    """Insert `corner` at the head of the list of `vertex`."""
    after[corner] = first[vertex]
    first[vertex] = corner


@lean_kernel
def unlink_corner(first, after, vertex, corner):
    """Remove `corner` from the list of `vertex`."""
    if first[vertex] == corner:
        first[vertex] = after[corner]
        return
    c = first[vertex]
    while after[c] != corner:
        c = after[c]
    after[c] = after[corner]


@kernel
def link_all(facets, alive, facet_count, first, after):
    """Build the lists of all facets marked `alive` among the first `facet_count`."""
    first[:] = -1
    for f in range(facet_count):
        if alive[f]:
            for i in range(3):
                link_corner(first, after, facets[f, i], 3 * f + i)


@kernel
def corner_lists(facets, vertices):
    """Return the corner lists `first` (vertices,) and `after` (3 m,), int32, of facets (m, 3)."""
    first = np.empty(vertices, np.int32)
    after = np.empty(3 * len(facets), np.int32)
    link_all(facets, np.ones(len(facets), np.bool_), len(facets), first, after)
    return first, after
