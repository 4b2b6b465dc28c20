"""The star, the set of facets that an operation changes, and checks of the new facets' shape."""

from collections import namedtuple

import numpy as np

from craftmesh.gradation.kernels.result_codes import ANGLE, DONE, LENGTH, NORMAL
from craftmesh.gradation.kernels.rings import has_corner
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import angle_score, keeps_normal, squared_distance

# All new facets share the corner `tip`. If `vertex` moves, the tip is the first free row of points and
# size, which has the new position; if not, the tip is the vertex itself. `gone` is the vertex that merges
# into `vertex`, or -1. `moved` and `dying` count the facets in state.star, which get new corners, and in
# state.dying, which are removed. `size` is the target length at the tip.
Star = namedtuple("Star", "vertex tip gone moved dying size")


@lean_kernel
def add_star(state, v, other, kept, count):
    """Append the facets at `v` that lack corner `other` to state.star, with corner `v` replaced by `kept`.

    count: number of facets that are there already. Return the new number, or -1 if there are too many.
    """
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


@lean_kernel
def star_at(state, v):
    """Return the star of a move of `v`, with its tip at v's position; `moved` is -1 if it is too big."""
    tip = state.used[0]
    for k in range(3):
        state.points[tip, k] = state.points[v, k]
    state.size[tip] = state.size[v]
    moved = add_star(state, v, np.int64(-1), tip, np.int64(0))
    return Star(v, tip, np.int64(-1), moved, np.int64(0), state.size[v])


@lean_kernel
def list_edge_facets(state, a, b):
    """List the facets on edge (a, b) in state.dying; return their number, or -1 if too many.

    They are those that a change of the edge removes or divides.
    """
    facets, after, dying = state.facets, state.after, state.dying
    count = 0
    c = state.first[a]
    while c >= 0:
        if has_corner(facets, c // 3, b):
            if count >= len(dying):
                return -1
            dying[count] = c // 3
            count += 1
        c = after[c]
    return count


@lean_kernel
def old_facet(state, star, i):
    """Return the star's i-th old facet: first the changing facets, then the removed ones."""
    return state.star[i] if i < star.moved else state.dying[i - star.moved]


@lean_kernel
def star_patch(state, star):
    """Return the common patch of the star's old facets.

    It is -1 if they have several patches, or if the same volume is on both sides of the patch.
    """
    patch = state.patch[state.star[0]]
    for i in range(star.moved + star.dying):
        if state.patch[old_facet(state, star, i)] != patch:
            return np.int64(-1)
    return patch if state.patch_sides[patch, 0] != state.patch_sides[patch, 1] else np.int64(-1)


@lean_kernel
def worst_score(state, star):
    """Return the smallest angle score of the star's old facets, 1 at angles of 15 or 135 degrees."""
    points, facets = state.points, state.facets
    worst = np.inf
    for i in range(star.moved + star.dying):
        f = old_facet(state, star, i)
        worst = min(worst, angle_score(points, facets[f, 0], facets[f, 1], facets[f, 2]))
    return worst


@lean_kernel
def shape_refusal(state, star, floor, rise, cosine, longest):
    """Return the reason why the star's new facets are bad (NORMAL, ANGLE, LENGTH), or DONE.

    The angle score must reach `floor`, or the old facets' smallest score plus `rise` if that is less. The
    score is 1 for a smallest angle of 15 or a largest of 135 degrees, more for better facets. An edge at
    the tip may exceed `longest` target lengths only if the star had an edge as long. Without this exception
    thin facets with long edges, too poor to be split, could neither collapse nor move. cosine: cosine of
    the largest angle between a normal and its reference normal.
    """
    points, size, reference = state.points, state.size, state.reference
    changed, corners, tip = state.star, state.star_corners, star.tip
    before = -1.0
    least = np.inf
    for i in range(star.moved):
        p = corners[i, 0]
        q = corners[i, 1]
        r = corners[i, 2]
        if not keeps_normal(points, reference, changed[i], p, q, r, cosine):
            return NORMAL
        score = angle_score(points, p, q, r)
        if score < floor:
            if least == np.inf:
                least = worst_score(state, star) + rise
            if score < least:
                return ANGLE
        for k in range(3):
            u = corners[i, k]
            if u != tip:
                limit = longest * 0.5 * (size[tip] + size[u])
                square = squared_distance(points, tip, u)
                if square <= limit * limit:
                    continue
                if before < 0.0:
                    before = _longest_before(state, star)
                if square > before:
                    return LENGTH
    return DONE


@lean_kernel
def _longest_before(state, star):
    """Return the square of the longest edge of the star's old facets."""
    points, facets = state.points, state.facets
    longest = 0.0
    for i in range(star.moved + star.dying):
        f = old_facet(state, star, i)
        for k in range(3):
            longest = max(longest, squared_distance(points, facets[f, k], facets[f, (k + 1) % 3]))
    return longest
