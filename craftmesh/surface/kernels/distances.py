"""Kernels for distances of places from facets and edges."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector, facet_distance2, segment_distance2
from craftmesh.surface.rounding import ROUNDING

# Facets per block; a block is skipped as a whole. With 8,400 facets, blocks of 16 take the same time and
# blocks of 64 half as long again.
BLOCK = 32


@kernel
def _block_boxes(centres, reach):
    """Return lowest and highest corners (b, 3) of boxes around the spheres of blocks of BLOCK facets.

    centres (f, 3), reach (f,): centres and radii of spheres around the facets.
    """
    count = (len(centres) + BLOCK - 1) // BLOCK
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for f in range(len(centres)):
        for k in range(3):
            low[f // BLOCK, k] = min(low[f // BLOCK, k], centres[f, k] - reach[f])
            high[f // BLOCK, k] = max(high[f // BLOCK, k], centres[f, k] + reach[f])
    return low, high


@lean_kernel
def _is_beyond(places, q, low, high, row, bound):
    """Return whether box `row` lies farther than `bound` from place q along one of the axes.

    low, high (b, 3): lowest and highest corners of the boxes.
    """
    for k in range(3):
        if places[q, k] < low[row, k] - bound or places[q, k] > high[row, k] + bound:
            return True
    return False


@kernel
def nearest_facets(places, points, facets, some, centres, reach):
    """Return nearest facets (q,) of places (q, 3), squared distances (q,), and sides (q,).

    The side is 1 for a place ahead of its facet, -1 behind. some (q,): a facet near each place, best the
    one with the nearest centre; its distance bounds the search. centres (f, 3), reach (f,): spheres around
    the facets. A facet is measured only if its sphere, and the box of its block, comes within this bound.
    Of equally near facets the first one is returned.
    """
    low, high = _block_boxes(centres, reach)
    nearest, side = np.zeros(len(places), np.int64), np.zeros(len(places), np.int64)
    distance2 = np.full(len(places), np.inf)
    for q in range(len(places)):
        s = some[q]
        bound = facet_distance2(points, facets[s, 0], facets[s, 1], facets[s, 2], places, q, np.inf)
        bound = np.sqrt(bound) * (1.0 + ROUNDING)
        for block in range(len(low)):
            if _is_beyond(places, q, low, high, block, bound):
                continue
            for f in range(block * BLOCK, min((block + 1) * BLOCK, len(facets))):
                x = centres[f, 0] - places[q, 0]
                y = centres[f, 1] - places[q, 1]
                z = centres[f, 2] - places[q, 2]
                far = bound + reach[f]
                if x * x + y * y + z * z > far * far:
                    continue
                a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
                d = facet_distance2(points, a, b, c, places, q, distance2[q])
                if d < distance2[q]:
                    distance2[q] = d
                    nearest[q] = f
        a, b, c = facets[nearest[q], 0], facets[nearest[q], 1], facets[nearest[q], 2]
        nx, ny, nz = area_vector(points, a, b, c)
        height = (places[q, 0] - points[a, 0]) * nx
        height += (places[q, 1] - points[a, 1]) * ny + (places[q, 2] - points[a, 2]) * nz
        side[q] = 1 if height > 0.0 else -1
    return nearest, distance2, side


@kernel
def nearest_on_edges(places, points, edges):
    """Return the point (q, 3) on the edges (e, 2) nearest to each place; without edges the place itself."""
    result = places.copy()
    for q in range(len(places)):
        best, nearest = np.inf, -1
        for e in range(len(edges)):
            d = segment_distance2(points, edges[e, 0], edges[e, 1], places, q)
            if d < best:
                best, nearest = d, e
        if nearest < 0:
            continue
        a, b = points[edges[nearest, 0]], points[edges[nearest, 1]]
        length2 = np.dot(b - a, b - a)
        t = 0.0
        if length2 > 0.0:
            t = min(1.0, max(0.0, np.dot(places[q] - a, b - a) / length2))
        result[q] = a + t * (b - a)
    return result
