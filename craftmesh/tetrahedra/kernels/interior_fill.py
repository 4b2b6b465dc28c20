"""Kernels that choose interior points: inside a first mesh, clear of facets, apart from each other."""

from collections import namedtuple

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.bins import cells_of_box

# Tolerance in barycentric coordinates: a point whose projection lies outside a facet by this still counts
# as above it.
RIM = 0.05
# points (n, 3), the first `vertices` of which are surface points; apart (n, 2): smallest distances of each
# point from surface points and from other points; stays (n,): mask of points chosen so far; bins: of all
# points.
Choice = namedtuple("Choice", "points vertices apart stays bins")


@kernel
def _barycentric_rows(a, b, c, d, rows):
    """Write the gradients (3, 3) of the barycentric coordinates of b, c, d; return False if V <= 0."""
    u, v, w = b - a, c - a, d - a
    rows[0], rows[1], rows[2] = np.cross(v, w), np.cross(w, u), np.cross(u, v)
    determinant = np.dot(rows[0], u)
    if determinant <= 0.0:
        return False
    rows /= determinant
    return True


@kernel
def mark_inside(candidates, bins, points, tets):
    """Return a mask (n,) of the candidates (n, 3) that lie in one of the tets (t, 4) on `points`.

    bins: of the candidates. Tets without a positive volume are skipped.
    """
    inside = np.zeros(len(candidates), np.bool_)
    rows = np.empty((3, 3))
    lower, upper = np.empty(3), np.empty(3)
    start, items, shape = bins.start, bins.items, bins.grid.shape
    for t in range(len(tets)):
        a, b, c, d = points[tets[t, 0]], points[tets[t, 1]], points[tets[t, 2]], points[tets[t, 3]]
        if not _barycentric_rows(a, b, c, d, rows):
            continue
        for k in range(3):
            lower[k], upper[k] = min(a[k], b[k], c[k], d[k]), max(a[k], b[k], c[k], d[k])
        i0, i1, j0, j1, k0, k1 = cells_of_box(bins.grid, lower, upper)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                row = (i * shape[1] + j) * shape[2]
                for x in range(start[row + k0], start[row + k1 + 1]):
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


@lean_kernel
def _is_over(u, v, normal, area2, foot):
    """Return whether a point projects into the facet with the corners a, a + u, a + v, up to RIM.

    foot: the point minus a; normal: u x v; area2: the normal's squared length.
    """
    dx, dy, dz = foot
    # Coordinates of the projection along u and v, from triple products with the normal.
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


@kernel
def mark_clear(candidates, clearance, bins, corners, reach):
    """Return a mask (n,) of the candidates (n, 3) at heights of at least `clearance` (n,) over all facets.

    Only facets that a candidate projects into count for it. bins: of the candidates; corners (m, 3, 3): of
    the facets; reach (m,): largest distance from each facet's bounding box at which candidates are checked.
    """
    clear = np.ones(len(candidates), np.bool_)
    lower, upper = np.empty(3), np.empty(3)
    start, items, shape = bins.start, bins.items, bins.grid.shape
    for f in range(len(corners)):
        a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
        u, v = b - a, c - a
        normal = np.cross(u, v)
        area2 = np.dot(normal, normal)
        if area2 == 0.0:
            continue
        for k in range(3):
            lower[k], upper[k] = min(a[k], b[k], c[k]) - reach[f], max(a[k], b[k], c[k]) + reach[f]
        i0, i1, j0, j1, k0, k1 = cells_of_box(bins.grid, lower, upper)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                row = (i * shape[1] + j) * shape[2]
                for x in range(start[row + k0], start[row + k1 + 1]):
                    p = items[x]
                    if not clear[p]:
                        continue
                    dx = candidates[p, 0] - a[0]
                    dy = candidates[p, 1] - a[1]
                    dz = candidates[p, 2] - a[2]
                    height = dx * normal[0] + dy * normal[1] + dz * normal[2]
                    if height * height < clearance[p] ** 2 * area2:
                        clear[p] = not _is_over(u, v, normal, area2, (dx, dy, dz))
    return clear


@lean_kernel
def _is_crowded(choice, p):
    """Return whether a point chosen so far is closer to point p than choice.apart allows."""
    points, stays = choice.points, choice.stays
    start, items, grid = choice.bins.start, choice.bins.items, choice.bins.grid
    shape = grid.shape
    from_vertex, from_other = choice.apart[p, 0], choice.apart[p, 1]
    reach = max(from_vertex, from_other)
    x, y, z = points[p, 0], points[p, 1], points[p, 2]
    box = (x - reach, y - reach, z - reach), (x + reach, y + reach, z + reach)
    i0, i1, j0, j1, k0, k1 = cells_of_box(grid, *box)
    for i in range(i0, i1 + 1):
        for j in range(j0, j1 + 1):
            row = (i * shape[1] + j) * shape[2]
            for k in range(start[row + k0], start[row + k1 + 1]):
                q = items[k]
                if stays[q]:
                    near = from_vertex if q < choice.vertices else from_other
                    dx, dy, dz = points[q, 0] - x, points[q, 1] - y, points[q, 2] - z
                    if dx * dx + dy * dy + dz * dz < near * near:
                        return True
    return False


@kernel
def thin_out(points, vertices, apart, bins):
    """Return a mask (n,) of points that stay: the first `vertices`, then, in order, points with room.

    apart (n, 2): smallest distances of each point from the first `vertices` and from others that stay.
    """
    stays = np.zeros(len(points), np.bool_)
    stays[:vertices] = True
    choice = Choice(points, vertices, apart, stays, bins)
    for p in range(vertices, len(points)):
        stays[p] = not _is_crowded(choice, p)
    return stays
