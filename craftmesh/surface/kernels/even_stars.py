"""Points whose facets cannot meet in more than their common vertices."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector, squared_distance
from craftmesh.surface.kernels.neighbours import hashed
from craftmesh.surface.kernels.triangles import FOLD


@kernel
def even_stars(points, facets):
    """Return a mask (n,) of points whose facets form one closed fan around them, a height over a plane.

    No two facets of such a point meet in more than their common vertices. The sum of hashes of the ends of
    the edges across from a point is 0 only if each of its edges has one facet on either side. A point with
    a facet that is nearly flat, or nearly upright on the plane, does not count.
    """
    normals, link = np.zeros(points.shape), np.zeros(len(points), np.uint64)
    turns, even = np.zeros(len(points), np.int32), np.ones(len(points), np.bool_)
    for f in range(len(facets)):
        x, y, z = area_vector(points, facets[f, 0], facets[f, 1], facets[f, 2])
        for k in range(3):
            v = facets[f, k]
            link[v] += hashed(facets[f, (k + 1) % 3]) - hashed(facets[f, (k + 2) % 3])
            normals[v, 0] += x
            normals[v, 1] += y
            normals[v, 2] += z
    for f in range(len(facets)):
        a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
        x, y, z = area_vector(points, a, b, c)
        edges = (
            squared_distance(points, a, b) + squared_distance(points, b, c) + squared_distance(points, c, a)
        )
        size2 = x * x + y * y + z * z
        is_thin = size2 <= (FOLD * edges) ** 2
        for k in range(3):
            v, b, c = facets[f, k], facets[f, (k + 1) % 3], facets[f, (k + 2) % 3]
            u, s, t = normals[v, 0], normals[v, 1], normals[v, 2]
            along = x * u + y * s + z * t
            if is_thin or along <= 0.0 or along * along <= FOLD * FOLD * size2 * (u * u + s * s + t * t):
                even[v] = False
            else:  # heights of the corners over a plane through the normal
                p, q, r = (0.0, t, -s) if abs(u) < abs(t) else (-s, u, 0.0)
                turns[v] += _height(points, v, b, p, q, r) < 0.0 <= _height(points, v, c, p, q, r)
    for v in range(len(points)):
        even[v] = even[v] and link[v] == 0 and turns[v] == 1
    return even


@lean_kernel
def _height(points, v, b, x, y, z):
    return (
        (points[b, 0] - points[v, 0]) * x
        + (points[b, 1] - points[v, 1]) * y
        + (points[b, 2] - points[v, 2]) * z
    )
