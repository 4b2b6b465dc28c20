"""Facets that a move of their points puts out of its bounds."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_measures import shape_of
from craftmesh.surface.kernels.facet_shape import area_vector
from craftmesh.surface.kernels.hinges import SHARP_COSINE, sharpest_on_facet


@lean_kernel
def _turns(points, moved, a, b, c, cosine):
    """Return whether facet (a, b, c) turns from `points` to `moved` by over the angle of this cosine."""
    x, y, z = area_vector(points, a, b, c)
    u, v, w = area_vector(moved, a, b, c)
    size = np.sqrt(x * x + y * y + z * z) * np.sqrt(u * u + v * v + w * w)
    return x * u + z * w + y * v < cosine * size


@lean_kernel
def _is_beyond(moved, facets, f, levels):
    """Return whether a corner of facet f lies outside the box with the planes `levels` (2, 3)."""
    for corner in range(3):
        for axis in range(3):
            x = moved[facets[f, corner], axis]
            if x < levels[0, axis] or x > levels[1, axis]:
                return True
    return False


@kernel
def spoiled(points, moved, facets, lists, changed, levels, bounds):
    """Return a mask (m,) of facets that break the bounds if their points (n, 3) move to `moved` (n, 3).

    Only facets in the mask `changed` (m,) are tested. A poor shape, a short edge or a sharp wedge does not
    count if it was no better before. lists: the facets' corner lists; levels (2, 3): planes of the box;
    bounds: the fields of `MoveBounds`.
    """
    turn, least_quality, least_edge = bounds
    cosine = np.cos(np.radians(turn))
    bad = np.zeros(len(facets), np.bool_)
    for f in range(len(facets)):
        if not changed[f]:
            continue
        a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
        quality, edge = shape_of(moved, a, b, c)
        if quality < least_quality:
            bad[f] = quality < shape_of(points, a, b, c)[0]
        elif edge < least_edge:
            bad[f] = edge < shape_of(points, a, b, c)[1]
        bad[f] = bad[f] or _is_beyond(moved, facets, f, levels) or _turns(points, moved, a, b, c, cosine)
        if not bad[f]:
            sharpest = sharpest_on_facet(moved, facets, lists[0], lists[1], f)
            if sharpest > SHARP_COSINE:
                bad[f] = sharpest > sharpest_on_facet(points, facets, lists[0], lists[1], f)
    return bad
