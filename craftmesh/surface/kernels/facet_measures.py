"""Measures of all facets (m, 3) on points (n, 3) at once."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector, squared_distance

TINY = np.finfo(np.float64).tiny
IDEAL = 4 * np.sqrt(3)  # makes the quality of an equilateral facet 1


@kernel
def area_vectors_of(points, facets):
    """Return the area vectors (m, 3) of the facets."""
    vectors = np.empty((len(facets), 3))
    for f in range(len(facets)):
        x, y, z = area_vector(points, facets[f, 0], facets[f, 1], facets[f, 2])
        vectors[f, 0] = 0.5 * x
        vectors[f, 1] = 0.5 * y
        vectors[f, 2] = 0.5 * z
    return vectors


@lean_kernel
def shape_of(points, a, b, c):
    """Return the quality, 4 sqrt(3) area / sum of squared edges, and the shortest edge of a facet."""
    x, y, z = area_vector(points, a, b, c)
    area = np.sqrt((0.5 * x) * (0.5 * x) + (0.5 * y) * (0.5 * y) + (0.5 * z) * (0.5 * z))
    first, second, third = (
        squared_distance(points, a, b),
        squared_distance(points, b, c),
        squared_distance(points, c, a),
    )
    return IDEAL * area / max(first + second + third, TINY), np.sqrt(min(first, second, third))


@kernel
def angles_of(points, facets):
    """Return the angles (m, 3) in degrees at the corners of the facets."""
    angles = np.empty(facets.shape)
    for f in range(len(facets)):
        for i in range(3):
            a, b, c = facets[f, i], facets[f, (i + 1) % 3], facets[f, (i + 2) % 3]
            x, y, z = area_vector(points, a, b, c)
            dot = (points[b, 0] - points[a, 0]) * (points[c, 0] - points[a, 0])
            dot += (points[b, 2] - points[a, 2]) * (points[c, 2] - points[a, 2])
            dot += (points[b, 1] - points[a, 1]) * (points[c, 1] - points[a, 1])
            angles[f, i] = np.degrees(np.arctan2(np.sqrt(x * x + y * y + z * z), dot))
    return angles


@kernel
def volumes_from(centre, points, facets):
    """Return signed volumes (m,) between point `centre` (3,) and facets, > 0 if `centre` is behind."""
    volumes = np.empty(len(facets))
    for f in range(len(facets)):
        a = facets[f, 0]
        x, y, z = area_vector(points, a, facets[f, 1], facets[f, 2])
        along = (points[a, 0] - centre[0]) * (0.5 * x) + (points[a, 2] - centre[2]) * (0.5 * z)
        volumes[f] = (along + (points[a, 1] - centre[1]) * (0.5 * y)) / 3.0
    return volumes
