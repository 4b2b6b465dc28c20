"""Smoothing passes: the neighbours that attract each point, and the points after the passes."""

import numpy as np

from craftmesh.jit import kernel
from craftmesh.surface.kernels.neighbours import COLUMNS, ID, IS_FEATURE, list_neighbours


@kernel
def drawn_by(facets, patch, held, lists):
    """Return start (n + 1,) and ids (k,): points ids[start[v] : start[v + 1]], ascending, attract point v.

    They are all neighbours, or on a line of feature edges the neighbours along it (`smoothing_neighbours`).
    patch (m,): patches of the facets (m, 3); held (n, 3): mask of coordinates that box planes hold; lists:
    the facets' corner lists.
    """
    start, ids = np.zeros(len(held) + 1, np.int32), np.empty(2 * facets.size, np.int32)
    near = np.empty((64, COLUMNS), np.int64)
    for v in range(len(held)):
        count = list_neighbours(facets, patch, lists, v, near)
        while count < 0:
            near = np.empty((2 * len(near), COLUMNS), np.int64)
            count = list_neighbours(facets, patch, lists, v, near)
        lines = near[:count, IS_FEATURE].sum()
        meets_boundary = lines > 2 and held[v].sum() >= 2
        n = start[v]
        for row in range(count):
            w = near[row, ID]
            along_box = (held[v, 0] & held[w, 0]) + (held[v, 1] & held[w, 1]) + (held[v, 2] & held[w, 2])
            if lines == 0 or (near[row, IS_FEATURE] and not (along_box >= 2 and meets_boundary)):
                ids[n] = w
                n += 1
        start[v + 1] = n
    return start, ids[: start[-1]].copy()


@kernel
def laps(points, weights, start, ids, stays):
    """Return points (n, 3) after a smoothing pass per weight; coordinates in the mask `stays` (n, 3) stay.

    The given points are overwritten. In each pass all points move by the fraction `weight` towards the
    means of the points that attract them (`start`, `ids` from `drawn_by`).
    """
    now, then = points, points.copy()
    for weight in weights:
        for v in range(len(points)):
            count = start[v + 1] - start[v]
            if count == 0:
                continue
            x = y = z = 0.0
            for n in range(start[v], start[v + 1]):
                x += now[ids[n], 0]
                y += now[ids[n], 1]
                z += now[ids[n], 2]
            if not stays[v, 0]:
                then[v, 0] = now[v, 0] + weight * (x / count - now[v, 0])
            if not stays[v, 1]:
                then[v, 1] = now[v, 1] + weight * (y / count - now[v, 1])
            if not stays[v, 2]:
                then[v, 2] = now[v, 2] + weight * (z / count - now[v, 2])
        now, then = then, now
    return now
