"""Edge swap inside patches: the other diagonal of two facets where corners come nearer to six facets each.

Even facets have angles of 60 degrees, so a vertex inside a patch has six; one on a line has a sixth of them
for each 60 degrees that the patch takes up there. No vertex moves; relaxation then makes facets even.
"""

import numpy as np

from craftmesh.gradation.kernels.codes import NO_NEED
from craftmesh.gradation.kernels.swap import turned
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import squared_distance

# What the sum over the four corners of the squares of facets too many or too few has to fall by.
LEAST_FALL = 0.5


@lean_kernel
def _angle_at(points, v, a, b):
    """Angle of the facet v, a, b at v in radians; 0 where an edge there has no length."""
    va, vb = squared_distance(points, v, a), squared_distance(points, v, b)
    ab = squared_distance(points, a, b)
    product = 2.0 * np.sqrt(va * vb)
    return np.arccos(min(max((va + vb - ab) / product, -1.0), 1.0)) if product > 0.0 else 0.0


@lean_kernel
def _too_many(state, v, patch):
    """Return how many more facets of the patch there are at `v` than even ones would be."""
    count, angle = 0, 0.0
    c = state.first[v]
    while c >= 0:
        f = c // 3
        if state.patch[f] == patch:
            count += 1
            if state.rank[v] > 0:
                a, b = state.facets[f, (c + 1) % 3], state.facets[f, (c + 2) % 3]
                angle += _angle_at(state.points, v, a, b)
        c = state.after[c]
    return count - (6.0 if state.rank[v] == 0 else 3.0 * angle / np.pi)


@lean_kernel
def even_valence(state, grid, limits, quad):
    """Turn the edge of a quad when the valences of its corners come nearer to even ones."""
    if quad.u < 0:
        return NO_NEED
    patch = state.patch[quad.f]
    lose = _too_many(state, quad.p, patch) + _too_many(state, quad.q, patch)
    gain = _too_many(state, quad.u, patch) + _too_many(state, quad.v, patch)
    if 2.0 * (lose - gain) - 4.0 <= LEAST_FALL:
        return NO_NEED
    return turned(state, grid, limits, quad, limits.floor)
