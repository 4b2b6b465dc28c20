"""Relaxation: vertices inside a patch move to the weighted centroid of their facets, for equal spacing."""

import numpy as np

from craftmesh.gradation.kernels.codes import LINK, NO_NEED
from craftmesh.gradation.kernels.slide import EVEN, slide_towards
from craftmesh.gradation.kernels.star import star_at
from craftmesh.jit import kernel
from craftmesh.surface.kernels.facet_shape import area_vector, score_of_angle

# Score of 30 degrees; no facet falls below the minimum of this score and its star's smallest.
SOUND = score_of_angle(30.0)


@kernel
def _centroid(state, star, place):
    """Set `place` to the centroid of the star's facets, weighted by area over target length squared.

    Return False if the facets have no area.
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
    """Move `v` to its star's centroid, or part of the way, if guards allow it; return DONE or why not."""
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
