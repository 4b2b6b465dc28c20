"""The guard of the order of facets round an edge: none passes through another that it has an edge with.

Facets with a common edge intersect nowhere else, so what looks for intersections sees nothing where one
turns past another: a crack facet is outside its grain then, and no mesher finds a place for it.
"""

import numpy as np

from craftmesh.gradation.kernels.rings import has_corner, third_corner
from craftmesh.gradation.kernels.star import old_facet
from craftmesh.jit import kernel, lean_kernel

# Two facets on an edge follow each other in any order.
LEAST_FACETS = 3


@lean_kernel
def breaks_order(state, star):
    """Tell whether round an edge of the star's new facets neighbours face each other with unlike sides.

    They may where some do round an edge of its old facets.
    """
    state.clock[1] += 1
    mark = state.clock[1]
    for i in range(star.moved):
        state.facet_stamp[state.star[i]] = mark
    for i in range(star.dying):
        state.facet_stamp[state.dying[i]] = mark
    for i in range(star.moved):
        for k in range(3):
            a, b = state.star_corners[i, k], state.star_corners[i, (k + 1) % 3]
            if _is_on_line(state, star, a) and _is_on_line(state, star, b):
                if not _follow(state, a, b, _list_new(state, star, i, a, b, mark)):
                    return not _broken_before(state, star)
    return False


@lean_kernel
def _is_on_line(state, star, a):
    """Tell whether vertex `a`, or what the star's vertex becomes, lies on a line."""
    if a != star.tip:
        return state.rank[a] > 0
    return state.rank[star.vertex] > 0 or (star.gone >= 0 and state.rank[star.gone] > 0)


@lean_kernel
def _list_new(state, star, i, a, b, mark):
    """List the facets that edge (a, b) will have; return how many, 0 if it is an edge of a row before."""
    corners = state.star_corners
    count = 0
    for j in range(star.moved):
        if has_corner(corners, j, a) and has_corner(corners, j, b):
            if j < i:
                return 0
            count = _add(state, count, corners, j, state.star[j], a, b)
    if a != state.used[0] and b != state.used[0]:
        count = _list_others(state, count, a, b, mark)
    return count


@lean_kernel
def _list_others(state, count, a, b, mark):
    """List the facets on edge (a, b) without the mark after the first `count`; return how many it are."""
    c = state.first[a]
    while c >= 0:
        f = c // 3
        if state.facet_stamp[f] != mark and has_corner(state.facets, f, b):
            count = _add(state, count, state.facets, f, f, a, b)
        c = state.after[c]
    return count


@lean_kernel
def _add(state, count, corners, row, f, a, b):
    """List the facet with the corners in a row, alike facet `f`: its third corner, and its sides.

    These are those it has ahead and behind in a turn about the axis from a to b.
    """
    if count >= len(state.edge_sides):
        return count
    k = 0
    while corners[row, k] != a:
        k += 1
    ahead = 1 if corners[row, (k + 1) % 3] == b else 0
    sides = state.patch_sides[state.patch[f]]
    state.edge_corner[count] = third_corner(corners, row, a, b)
    state.edge_sides[count, 0] = sides[ahead]
    state.edge_sides[count, 1] = sides[1 - ahead]
    return count + 1


@lean_kernel
def _follow(state, a, b, count):
    """Tell whether the `count` facets listed face each other with the same sides all round edge (a, b)."""
    if count < LEAST_FACETS:
        return True
    _set_turns(state, a, b, count)
    turn, sides = state.edge_turn, state.edge_sides
    for i in range(count):
        following, least = i, 2.0 * np.pi
        for j in range(count):
            way = (turn[j] - turn[i]) % (2.0 * np.pi)
            if j != i and way < least:
                following, least = j, way
        if sides[i, 0] != sides[following, 1]:
            return False
    return True


@kernel
def _set_turns(state, a, b, count):
    """Set how far each facet listed is turned about the axis from a to b, from the first one on."""
    points = state.points
    axis = points[b] - points[a]
    axis /= np.sqrt(np.dot(axis, axis))
    start = points[state.edge_corner[0]] - points[a]
    start -= np.dot(start, axis) * axis
    beside = np.cross(axis, start)
    for i in range(count):
        way = points[state.edge_corner[i]] - points[a]
        state.edge_turn[i] = np.arctan2(np.dot(way, beside), np.dot(way, start))


@lean_kernel
def _broken_before(state, star):
    """Tell whether neighbours face each other with unlike sides round an edge of the star's old facets."""
    for i in range(star.moved + star.dying):
        f = old_facet(state, star, i)
        for k in range(3):
            a, b = state.facets[f, k], state.facets[f, (k + 1) % 3]
            if not _follow(state, a, b, _list_others(state, 0, a, b, -1)):
                return True
    return False
