"""Reference normals of facets: the mean direction of a patch around each of its facets."""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector


@lean_kernel
def reference_normals(points, facets, patch, first, after, reference):
    """Set `reference` (m, 3) to mean unit normals of all facets of the patch at each facet's corners.

    The mean is weighted by area, which suppresses the meaningless normal of a needle or cap. Without any
    area the row stays unchanged.
    """
    for f in range(len(facets)):
        x = 0.0
        y = 0.0
        z = 0.0
        for i in range(3):
            c = first[facets[f, i]]
            while c >= 0:
                g = c // 3
                if patch[g] == patch[f]:
                    u, v, w = area_vector(points, facets[g, 0], facets[g, 1], facets[g, 2])
                    x += u
                    y += v
                    z += w
                c = after[c]
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            reference[f, 0] = x / length
            reference[f, 1] = y / length
            reference[f, 2] = z / length
