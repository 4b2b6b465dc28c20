"""Laps of smoothing: which neighbours draw each point, and the points after laps."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel


@lean_kernel
def _around(facets, patch, lists, v, near):
    """Fill a row of `near` per neighbour of v: its id, a patch, how many facets, if of several patches.

    Rows come by id. Return how many neighbours there are, or -1 where there is no room.
    """
    count = 0
    corner = lists[0][v]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        for step in range(1, 3):
            w = facets[f, (k + step) % 3]
            row = count
            while row > 0 and near[row - 1, 0] > w:
                row -= 1
            if row > 0 and near[row - 1, 0] == w:
                near[row - 1, 2] += 1
                near[row - 1, 3] |= near[row - 1, 1] != patch[f]
                continue
            if count == len(near):
                return -1
            for other in range(count, row, -1):
                for column in range(4):
                    near[other, column] = near[other - 1, column]
            near[row, 0], near[row, 1], near[row, 2], near[row, 3] = w, patch[f], 1, 0
            count += 1
        corner = lists[1][corner]
    return count


@kernel
def drawn_by(facets, patch, held, lists):
    """Return start (n + 1,) and ids: those that draw point v are ids[start[v] : start[v + 1]], ascending.

    As `smoothing_neighbours`; patch (m,): of each facet; held (n, 3) bool; lists: the facets' corner lists.
    """
    start, ids = np.zeros(len(held) + 1, np.int32), np.empty(2 * facets.size, np.int32)
    near = np.empty((64, 4), np.int64)
    for v in range(len(held)):
        count = _around(facets, patch, lists, v, near)
        while count < 0:
            near = np.empty((2 * len(near), 4), np.int64)
            count = _around(facets, patch, lists, v, near)
        lines = 0
        for row in range(count):
            near[row, 3] |= near[row, 2] != 2
            lines += near[row, 3]
        meets_boundary = lines > 2 and held[v].sum() >= 2
        n = start[v]
        for row in range(count):
            w = near[row, 0]
            along_box = (held[v, 0] & held[w, 0]) + (held[v, 1] & held[w, 1]) + (held[v, 2] & held[w, 2])
            if lines == 0 or (near[row, 3] and not (along_box >= 2 and meets_boundary)):
                ids[n] = w
                n += 1
        start[v + 1] = n
    return start, ids[: start[-1]].copy()


@kernel
def laps(points, weights, start, ids, stays):
    """Return points (n, 3) after a lap per weight, the coordinates that stay (n, 3) bool as they are.

    The given points are overwritten. In each lap all points go by its weight's part of their ways to the
    means of those that draw them.
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
