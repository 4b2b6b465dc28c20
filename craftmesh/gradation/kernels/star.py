"""The star: the facets that an operation changes, and the checks that all operations share."""

import numpy as np
from numba import njit

from craftmesh.gradation.kernels.codes import ANGLE, DONE, LENGTH, NORMAL
from craftmesh.gradation.kernels.facet_grid import insert_facet, star_intersects
from craftmesh.gradation.kernels.rings import has_corner
from craftmesh.surface.kernels.facet_shape import angle_score, keeps_normal, squared_distance


@njit(cache=True)
def add_star(state, v, other, kept, count):
    """Append the facets at `v` that do not hold `other`, with `v` read as `kept`; -1 when too many."""
    facets, after, star, corners = state.facets, state.after, state.star, state.star_corners
    c = state.first[v]
    while c >= 0:
        f = c // 3
        if not has_corner(facets, f, other):
            if count >= len(star):
                return -1
            star[count] = f
            for i in range(3):
                u = facets[f, i]
                corners[count, i] = kept if u == v else u
            count += 1
        c = after[c]
    return count


@njit(cache=True)
def star_of(state, v):
    """Put all facets at `v` into the star; return how many, or -1 when too many."""
    return add_star(state, v, np.int64(-1), v, np.int64(0))


@njit(cache=True)
def worst_score(state, moved, dying):
    """Return the least angle score of the star's old facets."""
    points, facets, star, lost = state.points, state.facets, state.star, state.dying
    worst = np.inf
    for i in range(moved + dying):
        f = star[i] if i < moved else lost[i - moved]
        worst = min(worst, angle_score(points, facets[f, 0], facets[f, 1], facets[f, 2]))
    return worst


@njit(cache=True)
def shape_refusal(state, moved, a, floor, cosine, longest):
    """Return why the star's new facets are bad, or DONE: normals against the references, angles, lengths.

    `a` already has its new place and `floor` is the least angle score.
    """
    points, size, reference = state.points, state.size, state.reference
    star, corners = state.star, state.star_corners
    for i in range(moved):
        p = corners[i, 0]
        q = corners[i, 1]
        r = corners[i, 2]
        if not keeps_normal(points, reference, star[i], p, q, r, cosine):
            return NORMAL
        if angle_score(points, p, q, r) < floor:
            return ANGLE
        for k in range(3):
            u = corners[i, k]
            if u != a:
                limit = longest * 0.5 * (size[a] + size[u])
                if squared_distance(points, a, u) > limit * limit:
                    return LENGTH
    return DONE


@njit(cache=True)
def hits(state, grid, moved, dying):
    """Tell whether the star's new facets meet each other or the rest of the surface."""
    star, lost, stamp = state.star, state.dying, state.facet_stamp
    mark = state.clock[1] + 1
    state.clock[1] += 2
    for i in range(moved):
        stamp[star[i]] = mark + 1
    for i in range(dying):
        stamp[lost[i]] = mark + 1
    return star_intersects(
        grid, state.points, state.facets, state.alive, stamp, mark, state.star_corners, moved
    )


@njit(cache=True)
def enter_star(state, grid, moved):
    """Enter the star's new facets into the grid."""
    points, star, corners = state.points, state.star, state.star_corners
    for i in range(moved):
        insert_facet(grid, points, star[i], corners[i, 0], corners[i, 1], corners[i, 2])
