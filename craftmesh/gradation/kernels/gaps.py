"""Gaps: how far a vertex stands over a facet, and how far two edges that cross are apart.

Widths count over the edge of an equilateral facet as large as the facet, or over the root of the area of
the parallelogram that two edges span.
"""

import numpy as np

from craftmesh.gradation.kernels.rings import has_corner
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector

# The squared edge of an equilateral facet over twice its area.
EDGE = 2.0 / np.sqrt(3.0)
# Times a width: what is farther off than that is so whatever the rounding.
SURELY = 1.0 + 1e-6


@lean_kernel
def share_edge(facets, f, a, b, c):
    """Tell whether facet `f` has two corners of facet (a, b, c): they make a wedge, and no gap."""
    return has_corner(facets, f, a) + has_corner(facets, f, b) + has_corner(facets, f, c) > 1


@lean_kernel
def may_overlap(points, planes, a, b, c, facets, f, reach):
    """Tell whether facet `f` may come within `reach` of the one of the `planes`, of corners (a, b, c).

    The two have no common edge (share_edge).
    """
    above = False
    below = False
    for n in range(3):
        v = facets[f, n]
        if v != a and v != b and v != c:
            h = height_over(points, planes, 0, v)
            above = above or h > -reach
            below = below or h < reach
    if not (above and below):
        return False
    beyond = 7
    for n in range(3):
        v = facets[f, n]
        if v == a or v == b or v == c:
            # A shared corner lies beyond the edges that it is an end of.
            beyond &= 5 if v == a else (3 if v == b else 6)
            continue
        for k in range(3):
            if beyond & (1 << k) and height_over(points, planes, k + 1, v) <= reach:
                beyond &= ~(1 << k)
    return beyond == 0


@lean_kernel
def unit_normal(points, a, b, c):
    """Return the components of the unit normal of facet (a, b, c), of zero where it has no area."""
    x, y, z = area_vector(points, a, b, c)
    size = np.sqrt(x * x + y * y + z * z)
    scale = 1.0 / size if size > 0.0 else 0.0
    return x * scale, y * scale, z * scale


@lean_kernel
def is_on_one_side(points, normal, corners, others, reach):
    """Tell whether the corners that only `others` (3,) has lie over `reach` on one side of a facet's plane.

    normal: of the facet of the `corners` (3,). A quick look before `may_overlap`, which decides.
    """
    x, y, z = normal
    a = corners[0]
    reach *= SURELY
    above = False
    below = False
    for n in range(3):
        v = others[n]
        if v != a and v != corners[1] and v != corners[2]:
            h = x * (points[v, 0] - points[a, 0]) + y * (points[v, 1] - points[a, 1])
            h += z * (points[v, 2] - points[a, 2])
            above = above or h > -reach
            below = below or h < reach
    return not (above and below)


@lean_kernel
def is_farther(points, a, b, c, v, share):
    """Tell whether `v` is surely more than `share` of its edge off the plane of facet (a, b, c)."""
    x, y, z = area_vector(points, a, b, c)
    size2 = x * x + y * y + z * z
    h = x * (points[v, 0] - points[a, 0]) + y * (points[v, 1] - points[a, 1])
    h += z * (points[v, 2] - points[a, 2])
    # height times the size against share of the edge times the size, which is the root of EDGE size^3
    return h * h > (SURELY * share) ** 2 * EDGE * size2 * np.sqrt(size2)


@lean_kernel
def height_over(points, planes, row, v):
    """Return how far `v` lies over the plane in a row (set_planes): the facet's, or one across its edge."""
    return (
        planes[row, 0] * points[v, 0]
        + planes[row, 1] * points[v, 1]
        + planes[row, 2] * points[v, 2]
        - planes[row, 3]
    )


@lean_kernel
def is_inside(points, planes, v):
    """Tell whether the foot of `v` on the facet of the `planes` lies inside it."""
    return (
        height_over(points, planes, 1, v) <= 0.0
        and height_over(points, planes, 2, v) <= 0.0
        and height_over(points, planes, 3, v) <= 0.0
    )


@lean_kernel
def edge_of_area(points, a, b, c):
    """Return the edge of an equilateral facet as large as (a, b, c)."""
    x, y, z = area_vector(points, a, b, c)
    return np.sqrt(EDGE * np.sqrt(x * x + y * y + z * z))


@lean_kernel
def crossing_width(points, p, q, u, v):
    """Return the relative width of the gap between two edges that cross, infinite where they do not."""
    dx, dy, dz = points[q, 0] - points[p, 0], points[q, 1] - points[p, 1], points[q, 2] - points[p, 2]
    ex, ey, ez = points[v, 0] - points[u, 0], points[v, 1] - points[u, 1], points[v, 2] - points[u, 2]
    wx, wy, wz = points[u, 0] - points[p, 0], points[u, 1] - points[p, 1], points[u, 2] - points[p, 2]
    nx = dy * ez - dz * ey
    ny = dz * ex - dx * ez
    nz = dx * ey - dy * ex
    n2 = nx * nx + ny * ny + nz * nz
    if n2 <= 0.0:
        return np.inf
    s = ((wy * ez - wz * ey) * nx + (wz * ex - wx * ez) * ny + (wx * ey - wy * ex) * nz) / n2
    t = ((wy * dz - wz * dy) * nx + (wz * dx - wx * dz) * ny + (wx * dy - wy * dx) * nz) / n2
    if not (0.0 < s < 1.0 and 0.0 < t < 1.0):
        return np.inf
    length = np.sqrt(n2)
    return abs(wx * nx + wy * ny + wz * nz) / (length * np.sqrt(length))
