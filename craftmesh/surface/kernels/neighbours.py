"""The neighbours of a vertex, and which of its edges are feature edges."""

import numpy as np

from craftmesh.jit import lean_kernel

# Columns of a row per neighbour: its id, the patch of one facet of the edge to it, the number of the edge's
# facets, 1 if the edge is a feature, and the sum of the hashes of the facets' patches. Equal sums mean the
# same patches.
ID, PATCH, FACETS, IS_FEATURE, PATCHES = range(5)
COLUMNS = PATCHES + 1


@lean_kernel
def hashed(number):
    """Return the hash of a number >= 0, as uint64. Different numbers have different hashes."""
    key = np.uint64(number + 1) * np.uint64(0x9E3779B97F4A7C15)
    return (key ^ (key >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)


@lean_kernel
def list_neighbours(facets, patch, lists, v, rows):
    """Fill one of the `rows` (r, COLUMNS) per neighbour of vertex v, by ascending id; return their number.

    patch (m,): patches of the facets (m, 3); lists: the facets' corner lists. The number is -1 if there are
    more neighbours than rows.
    """
    count = 0
    corner = lists[0][v]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        for step in range(1, 3):
            w = facets[f, (k + step) % 3]
            row = count
            while row > 0 and rows[row - 1, ID] > w:
                row -= 1
            if row > 0 and rows[row - 1, ID] == w:
                row -= 1
            elif count == len(rows):
                return -1
            else:
                for other in range(count, row, -1):
                    for column in range(COLUMNS):
                        rows[other, column] = rows[other - 1, column]
                rows[row, ID], rows[row, PATCH] = w, patch[f]
                rows[row, FACETS] = rows[row, IS_FEATURE] = rows[row, PATCHES] = 0
                count += 1
            rows[row, FACETS] += 1
            rows[row, IS_FEATURE] |= rows[row, PATCH] != patch[f]
            rows[row, PATCHES] += np.int64(hashed(patch[f]))
        corner = lists[1][corner]
    for row in range(count):
        rows[row, IS_FEATURE] |= rows[row, FACETS] != 2
    return count
