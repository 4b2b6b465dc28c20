"""Kernels that choose interior points: inside a first mesh, clear of facets, apart from each other."""

import numpy as np
from numba import njit

# A point whose foot lies this far outside a facet (in barycentric units) still counts as over it.
RIM = 0.05


@njit(cache=True)
def _cell_of(point, low, width, shape):
    """Index of the grid cell that holds `point`, clamped to the grid."""
    index = 0
    for k in range(3):
        i = int((point[k] - low[k]) / width)
        index = index * shape[k] + min(max(i, 0), shape[k] - 1)
    return index


@njit(cache=True)
def _range_of(lower, upper, low, width, shape, first, last):
    """Write the first and last cell along each axis of the box lower..upper."""
    for k in range(3):
        first[k] = min(max(int((lower[k] - low[k]) / width), 0), shape[k] - 1)
        last[k] = min(max(int((upper[k] - low[k]) / width), 0), shape[k] - 1)


@njit(cache=True)
def bucket_points(points, low, width, shape):
    """Return (start, items): the points of grid cell c are items[start[c]:start[c + 1]], ascending."""
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    for p in range(len(points)):
        start[_cell_of(points[p], low, width, shape) + 1] += 1
    start = np.cumsum(start)
    free = start[:-1].copy()
    items = np.empty(len(points), np.int64)
    for p in range(len(points)):
        cell = _cell_of(points[p], low, width, shape)
        items[free[cell]] = p
        free[cell] += 1
    return start, items


@njit(cache=True)
def _barycentric_rows(a, b, c, d, rows):
    """Write the gradients of the barycentric coordinates of b, c, d; False for a flat tet."""
    u, v, w = b - a, c - a, d - a
    rows[0], rows[1], rows[2] = np.cross(v, w), np.cross(w, u), np.cross(u, v)
    determinant = np.dot(rows[0], u)
    if determinant <= 0.0:
        return False
    rows /= determinant
    return True


@njit(cache=True)
def mark_inside(candidates, start, items, low, width, shape, points, tets):
    """Return whether each candidate (n, 3) lies in one of the tets (t, 4) on points."""
    inside = np.zeros(len(candidates), np.bool_)
    rows = np.empty((3, 3))
    lower, upper = np.empty(3), np.empty(3)
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for t in range(len(tets)):
        a, b, c, d = points[tets[t, 0]], points[tets[t, 1]], points[tets[t, 2]], points[tets[t, 3]]
        if not _barycentric_rows(a, b, c, d, rows):
            continue
        for k in range(3):
            lower[k], upper[k] = min(a[k], b[k], c[k], d[k]), max(a[k], b[k], c[k], d[k])
        _range_of(lower, upper, low, width, shape, first, last)
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                row = (i * shape[1] + j) * shape[2]
                for x in range(start[row + first[2]], start[row + last[2] + 1]):
                    p = items[x]
                    if inside[p]:
                        continue
                    dx = candidates[p, 0] - a[0]
                    dy = candidates[p, 1] - a[1]
                    dz = candidates[p, 2] - a[2]
                    s = rows[0, 0] * dx + rows[0, 1] * dy + rows[0, 2] * dz
                    t_ = rows[1, 0] * dx + rows[1, 1] * dy + rows[1, 2] * dz
                    r = rows[2, 0] * dx + rows[2, 1] * dy + rows[2, 2] * dz
                    inside[p] = s >= 0.0 and t_ >= 0.0 and r >= 0.0 and s + t_ + r <= 1.0
    return inside


@njit(cache=True)
def _is_over(u, v, normal, area2, dx, dy, dz):
    """Whether the foot of the point at (dx, dy, dz) from corner a lies in the facet a, a + u, a + v."""
    # Coordinates along u and v of the foot, from triple products with the normal.
    s = (
        (dy * v[2] - dz * v[1]) * normal[0]
        + (dz * v[0] - dx * v[2]) * normal[1]
        + (dx * v[1] - dy * v[0]) * normal[2]
    ) / area2
    r = (
        (u[1] * dz - u[2] * dy) * normal[0]
        + (u[2] * dx - u[0] * dz) * normal[1]
        + (u[0] * dy - u[1] * dx) * normal[2]
    ) / area2
    return s > -RIM and r > -RIM and s + r < 1.0 + RIM


@njit(cache=True)
def mark_clear(candidates, size, reach, start, items, low, width, shape, points, facets, clearance):
    """Return whether each candidate is `clearance` times its size away from the facets below or above it.

    reach (m,): the largest distance at which facet f can matter.
    """
    clear = np.ones(len(candidates), np.bool_)
    lower, upper = np.empty(3), np.empty(3)
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for f in range(len(facets)):
        a, b, c = points[facets[f, 0]], points[facets[f, 1]], points[facets[f, 2]]
        u, v = b - a, c - a
        normal = np.cross(u, v)
        area2 = np.dot(normal, normal)
        if area2 == 0.0:
            continue
        for k in range(3):
            lower[k], upper[k] = min(a[k], b[k], c[k]) - reach[f], max(a[k], b[k], c[k]) + reach[f]
        _range_of(lower, upper, low, width, shape, first, last)
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                row = (i * shape[1] + j) * shape[2]
                for x in range(start[row + first[2]], start[row + last[2] + 1]):
                    p = items[x]
                    if not clear[p]:
                        continue
                    dx = candidates[p, 0] - a[0]
                    dy = candidates[p, 1] - a[1]
                    dz = candidates[p, 2] - a[2]
                    height = dx * normal[0] + dy * normal[1] + dz * normal[2]
                    if height * height < (clearance * size[p]) ** 2 * area2:
                        clear[p] = not _is_over(u, v, normal, area2, dx, dy, dz)
    return clear


@njit(cache=True)
def _is_crowded(point, limit, count, placed, head, following, low, width, shape, first, last):
    """Whether a placed point lies within `limit`, which has a value for vertices and one for the rest."""
    reach = max(limit[0], limit[1])
    _range_of(point - reach, point + reach, low, width, shape, first, last)
    for i in range(first[0], last[0] + 1):
        for j in range(first[1], last[1] + 1):
            for k in range(first[2], last[2] + 1):
                p = head[(i * shape[1] + j) * shape[2] + k]
                while p >= 0:
                    near = limit[0] if p < count else limit[1]
                    dx, dy, dz = placed[p, 0] - point[0], placed[p, 1] - point[1], placed[p, 2] - point[2]
                    if dx * dx + dy * dy + dz * dz < near * near:
                        return True
                    p = following[p]
    return False


@njit(cache=True)
def thin_out(candidates, size, vertices, from_vertex, apart, low, width, shape):
    """Return which candidates stay, taken in order, each a multiple of its size from all that are placed.

    `from_vertex` and `apart` are the multiples for the surface's vertices (placed first) and for others.
    """
    head = np.full(shape[0] * shape[1] * shape[2], -1, np.int64)
    count = len(vertices)
    following = np.full(count + len(candidates), -1, np.int64)
    placed = np.empty((count + len(candidates), 3))
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    limit = np.empty(2)
    stays = np.zeros(len(candidates), np.bool_)
    total = 0
    for i in range(count + len(candidates)):
        point = vertices[i] if i < count else candidates[i - count]
        if i >= count:
            limit[0], limit[1] = from_vertex * size[i - count], apart * size[i - count]
            if _is_crowded(point, limit, count, placed, head, following, low, width, shape, first, last):
                continue
            stays[i - count] = True
        cell = _cell_of(point, low, width, shape)
        placed[total] = point
        following[total] = head[cell]
        head[cell] = total
        total += 1
    return stays
