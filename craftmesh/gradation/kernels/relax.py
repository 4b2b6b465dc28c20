"""Relaxation: vertices inside a patch move to the weighted centroid of their facets, for equal spacing."""

import numpy as np

from craftmesh.gradation.kernels.result_codes import LINK, NO_NEED
from craftmesh.gradation.kernels.slide import EVEN, slide_towards
from craftmesh.gradation.kernels.star import star_at
from craftmesh.jit import kernel
from craftmesh.surface.kernels.facet_shape import area_vector, score_of_angle

# Angle score of 30 degrees. No facet falls below this score, or below the smallest score of the old facets
# at the vertex if that is less.
SOUND = score_of_angle(30.0)


@kernel
def _centroid(state, star, place):
    """Set `place` (3,) to the centroid of the star's facets, the facets around the vertex.

    The facets' weights are area over target length squared. Return False if the facets have no area.
    """
    points, size = state.points, state.size
    total = 0.0
    place[:] = 0.0
    for i in range(star.moved):
        a, b, c = state.star_corners[i]
        x, y, z = area_vector(points, a, b, c)
        weight = np.sqrt(x * x + y * y + z * z) / (size[a] + size[b] + size[c]) ** 2
        total += weight
        for k in range(3):
            place[k] += weight * (points[a, k] + points[b, k] + points[c, k]) / 3.0
    if total > 0.0:
        place /= total
    return total > 0.0


@kernel
def relax_vertex(state, grid, limits, v):
    """Move `v` to the centroid of its facets, or half or a quarter of the way; return DONE or why not.

    Moves of less than EVEN target lengths are not tried. Every new facet must have the angle score of 30
    degrees, or at least the smallest score of the old facets.
    """
    star = star_at(state, v)
    goal = np.empty(3)
    if star.moved <= 0:
        return LINK
    if not _centroid(state, star, goal):
        return NO_NEED
    way2 = 0.0
    for k in range(3):
        way2 += (goal[k] - state.points[v, k]) ** 2
    if way2 < (EVEN * state.size[v]) ** 2:
        return NO_NEED
    return slide_towards(state, grid, limits, star, goal, SOUND, 0.0)
