"""Sorting of facets by their point ids."""

import numpy as np

from craftmesh.jit import kernel


@kernel
def turned_to_least(facets, new):
    """Return facets (m, 3) with point ids new[id], each rotated so that its smallest new id is first."""
    turned = np.empty_like(facets)
    for f in range(len(facets)):
        a, b, c = new[facets[f, 0]], new[facets[f, 1]], new[facets[f, 2]]
        if b < a and b < c:
            a, b, c = b, c, a
        elif c < a and c < b:
            a, b, c = c, a, b
        turned[f, 0] = a
        turned[f, 1] = b
        turned[f, 2] = c
    return turned


@kernel
def rows_by_points(facets, count):
    """Return the rows (m,) of facets (m, 3), sorted by smallest, middle and largest point id.

    The first corner of each facet must be its smallest id (not checked); count: number of points. Facets
    on the same points keep their order.
    """
    end = np.zeros(count + 1, np.int64)
    for f in range(len(facets)):
        end[facets[f, 0] + 1] += 1
    end = np.cumsum(end)
    rows = np.empty(len(facets), np.int64)
    start = end.copy()
    for f in range(len(facets)):
        a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
        place = end[a]
        while place > start[a]:
            other = rows[place - 1]
            p, q = facets[other, 1], facets[other, 2]
            if (min(p, q), max(p, q)) <= (min(b, c), max(b, c)):
                break
            rows[place] = other
            place -= 1
        rows[place] = f
        end[a] += 1
    return rows
