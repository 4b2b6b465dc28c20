"""Hinges: pairs of facets on a common edge, and how sharp the wedges between them are.

The angle of a hinge is the angle between the half planes of its facets, 180 degrees for coplanar facets.
The smallest angle around an edge is always between two consecutive facets.
"""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.facet_shape import area_vector

# Angle in degrees below which a wedge is sharp; tetrahedra in a wedge have dihedral angles as small as it.
SHARP_WEDGE = 12.0
SHARP_COSINE = np.cos(np.radians(SHARP_WEDGE))
# Cosine that stands for "no hinge"; it is below the cosine of any angle.
OPEN = -2.0


@lean_kernel
def _sharpest_along(points, facets, after, c, b, d):
    """Return the largest cosine of angles between the facet of corner `c` and others on its edge to `b`.

    The edge is from the vertex of corner `c` to vertex `b`. The result is OPEN without others. Only facets
    from corner `d` on in the list of the vertex of `c` are compared.
    """
    ahead, behind = facets[c // 3, (c + 1) % 3], facets[c // 3, (c + 2) % 3]
    a = facets[c // 3, c % 3]
    goes_on = ahead == b
    x, y, z = area_vector(points, a, ahead, behind)
    size2 = x * x + y * y + z * z
    largest = OPEN
    while d >= 0:
        ahead, behind = facets[d // 3, (d + 1) % 3], facets[d // 3, (d + 2) % 3]
        if (ahead == b or behind == b) and d != c:
            u, v, w = area_vector(points, a, ahead, behind)
            size = np.sqrt(size2 * (u * u + v * v + w * w))
            if size > 0.0:
                along = (x * u + y * v + z * w) / size
                largest = max(largest, along if (ahead == b) == goes_on else -along)
        d = after[d]
    return largest


@lean_kernel
def sharpest_on_facet(points, facets, first, after, f):
    """Return the largest cosine of angles between facet `f` and facets on its edges, OPEN for none."""
    largest = OPEN
    for k in range(3):
        a, b = facets[f, k], facets[f, (k + 1) % 3]
        largest = max(largest, _sharpest_along(points, facets, after, 3 * f + k, b, first[a]))
    return largest


@kernel
def sharpest_cosines(points, facets, first, after):
    """Return for each of the facets (m, 3) the largest cosine (m,) of its angles with facets on its edges.

    first, after: the facets' corner lists. The cosine is OPEN for a facet alone on its edges.
    """
    cosines = np.empty(len(facets))
    for f in range(len(facets)):
        cosines[f] = sharpest_on_facet(points, facets, first, after, f)
    return cosines


@kernel
def sharp_edges(points, facets, cosine):
    """Return edges (k, 2) with two facets that enclose a sharp wedge; lower point first.

    Sharp: the cosine of the angle between the facets (180 degrees if coplanar) exceeds `cosine`. facets
    (m, 3). An edge may be listed several times.
    """
    first, after = corner_lists(facets, len(points))
    edges = np.empty((3 * len(facets), 2), np.int64)
    count = 0
    for a in range(len(points)):
        c = first[a]
        while c >= 0:
            for k in range(1, 3):
                b = facets[c // 3, (c + k) % 3]
                if b > a and _sharpest_along(points, facets, after, c, b, after[c]) > cosine:
                    edges[count, 0] = a
                    edges[count, 1] = b
                    count += 1
            c = after[c]
    return edges[:count].copy()
