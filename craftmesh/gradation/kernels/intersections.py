"""Intersection tests of new facets with each other and with nearby facets."""

import numpy as np

from craftmesh.gradation.kernels.facet_grid import list_hits
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector, squared_distance
from craftmesh.surface.kernels.triangles import triangles_intersect
from craftmesh.surface.rounding import SAME_PLACE


@lean_kernel
def set_planes(points, corners, planes):
    """Set the rows of `planes` (4, 5) for the facet `corners`.

    A row is a unit normal, an offset, and the height that counts as contact. Row 0 is the facet's plane;
    row k + 1 is the perpendicular plane through edge k, its normal pointing away from the facet.
    """
    a, b, c = corners
    x, y, z = area_vector(points, a, b, c)
    length = np.sqrt(x * x + y * y + z * z)
    scale = 1.0 / length if length > 0.0 else 0.0
    # a point within this height counts as on the facet's plane, and the exact test decides
    contact = SAME_PLACE * (
        np.sqrt(squared_distance(points, a, b)) + np.sqrt(squared_distance(points, a, c))
    )
    x *= scale
    y *= scale
    z *= scale
    planes[0, 0] = x
    planes[0, 1] = y
    planes[0, 2] = z
    for k in range(3):
        u = corners[k]
        v = corners[(k + 1) % 3]
        ex = points[v, 0] - points[u, 0]
        ey = points[v, 1] - points[u, 1]
        ez = points[v, 2] - points[u, 2]
        length = np.sqrt(ex * ex + ey * ey + ez * ez)
        scale = 1.0 / length if length > 0.0 else 0.0
        planes[k + 1, 0] = (ey * z - ez * y) * scale
        planes[k + 1, 1] = (ez * x - ex * z) * scale
        planes[k + 1, 2] = (ex * y - ey * x) * scale
    for k in range(4):
        u = corners[max(0, k - 1)]
        offset = 0.0
        for axis in range(3):
            offset += planes[k, axis] * points[u, axis]
        planes[k, 3] = offset
        planes[k, 4] = contact


@lean_kernel
def _apart(points, planes, corners, p, q, r):
    """Return True if facet (p, q, r) surely meets the facet `corners` at most in shared corners.

    planes: of the facet `corners` (`set_planes`). The condition is that the unshared corners among p, q, r
    lie strictly on one side of that facet's plane, or strictly beyond one of its edges whose opposite
    corner is not shared. False means undecided; an exact test must follow.
    """
    above = False
    below = False
    near = False
    shared = 0
    outside = 7
    for n in range(3):
        v = p if n == 0 else (q if n == 1 else r)
        x = points[v, 0]
        y = points[v, 1]
        z = points[v, 2]
        for k in range(3):
            if corners[k] == v:
                shared += 1
                outside &= ~(1 << ((k + 1) % 3))
                v = -1
        if v < 0:
            continue
        h = planes[0, 0] * x + planes[0, 1] * y + planes[0, 2] * z - planes[0, 3]
        if abs(h) <= planes[0, 4]:
            near = True
        above = above or h > 0.0
        below = below or h < 0.0
        for k in range(3):
            h = planes[k + 1, 0] * x + planes[k + 1, 1] * y + planes[k + 1, 2] * z - planes[k + 1, 3]
            if h <= planes[k + 1, 4]:
                outside &= ~(1 << k)
    if shared == 3:
        return False
    return outside != 0 or (above != below and not near)


@lean_kernel
def _meets_star(points, planes, star, i):
    """Return whether the new facet star[i] meets one of the new facets star[:i] before it.

    planes: bounding planes of star[i], from `set_planes`.
    """
    a, b, c = star[i]
    for j in range(i):
        if _apart(points, planes, star[i], star[j, 0], star[j, 1], star[j, 2]):
            continue
        if triangles_intersect(points, a, b, c, star[j, 0], star[j, 1], star[j, 2]):
            return True
    return False


@lean_kernel
def _meets_candidates(grid, near, points, facets, planes, corners):
    """Return whether the new facet `corners` meets one of the first `near` facets in grid.candidate.

    planes: bounding planes of the new facet, from `set_planes`.
    """
    a, b, c = corners
    for n in range(list_hits(grid, near, points, a, b, c)):
        f = grid.hits[n]
        if _apart(points, planes, corners, facets[f, 0], facets[f, 1], facets[f, 2]):
            continue
        if triangles_intersect(points, a, b, c, facets[f, 0], facets[f, 1], facets[f, 2]):
            return True
    return False


@kernel
def star_intersects(grid, points, facets, near, star, count, alone):
    """Return whether one of the new facets star[:count] meets another one or a candidate.

    star (k, 3): corners of the new facets; near: number of facets in grid.candidate; alone: whether new
    facets are compared only with candidates, because they cannot meet each other (`sheets`).
    """
    if alone and near == 0:
        return False
    planes = np.empty((4, 5))
    for i in range(count):
        set_planes(points, star[i], planes)
        if not alone and _meets_star(points, planes, star, i):
            return True
        if _meets_candidates(grid, near, points, facets, planes, star[i]):
            return True
    return False
