"""Ranks of vertices: how free the lines and surfaces that meet at a vertex leave it to move."""

import numpy as np

from craftmesh.jit import kernel
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.neighbours import COLUMNS, IS_FEATURE, PATCHES, list_neighbours

# Ranks of vertices: a patch leaves two directions free, a line of feature edges one, a junction none.
IN_PATCH, ON_LINE, AT_JUNCTION = 0, 1, 2


@kernel
def line_ranks(facets, patch, count):
    """Return the ranks (count,) of vertices: IN_PATCH, ON_LINE or AT_JUNCTION.

    A vertex without feature edges is in a patch. One with two feature edges between the same patches is on
    a line; any other is a junction. Feature edges do not have two facets of one patch.
    patch (m,): patches of the facets (m, 3).
    """
    lists = corner_lists(facets, count)
    rank = np.full(count, AT_JUNCTION)
    rows = np.empty((64, COLUMNS), np.int64)
    for v in range(count):
        listed = list_neighbours(facets, patch, lists, v, rows)
        while listed < 0:
            rows = np.empty((2 * len(rows), COLUMNS), np.int64)
            listed = list_neighbours(facets, patch, lists, v, rows)
        lines, one, other = 0, np.int64(0), np.int64(0)
        for row in range(listed):
            if rows[row, IS_FEATURE]:
                lines, one, other = lines + 1, other, rows[row, PATCHES]
        if lines == 0:
            rank[v] = IN_PATCH
        elif lines == 2 and one == other:
            rank[v] = ON_LINE
    return rank
