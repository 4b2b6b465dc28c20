"""The guarded operation: every change of the surface is checked first and made afterwards.

An operation fills the star: facets with their new corners, facets to remove, and the position of the tip,
the corner that all new facets share. `refusal` returns the reason of the first guard that forbids the
change, checks cheap guards first, and does not change the mesh. `commit` makes the change that `refusal`
allowed.
"""

import numpy as np

from craftmesh.gradation.kernels.cones import book_drift, drift_allows, grain_cones
from craftmesh.gradation.kernels.crack_guard import leaves_crack, leaves_front
from craftmesh.gradation.kernels.distance_samples import (
    TOO_MANY,
    attach_witnesses,
    collect,
    find_new_homes,
    set_free,
)
from craftmesh.gradation.kernels.facet_grid import GONE, gather_candidates, insert_facet
from craftmesh.gradation.kernels.intersections import star_intersects
from craftmesh.gradation.kernels.result_codes import DISTANCE, DONE, INTERSECTION, VOLUME, WEDGE
from craftmesh.gradation.kernels.sheets import keep_foreign, no_sheet, set_rows, sheet_of
from craftmesh.gradation.kernels.star import add_star, old_facet, shape_refusal
from craftmesh.gradation.kernels.wedge_guard import sharpens_wedge
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.corner_lists import link_corner, unlink_corner


@lean_kernel
def attempt(state, grid, limits, star, floor, rise):
    """Make the star's change if every guard allows it; return DONE or the reason why not.

    floor, rise: the new facets need the angle score `floor` or the smallest old score plus `rise`.
    """
    reason = refusal(state, grid, limits, star, floor, rise)
    if reason == DONE:
        commit(state, grid, star)
    return reason


@lean_kernel
def refusal(state, grid, limits, star, floor, rise):
    """Return the reason why the star may not change, or DONE.

    New facets must have the angle score `floor`, or, if that is less, the smallest score of the old facets
    plus `rise`. More score is better; it is 1 at a smallest angle of 15 or a largest of 135 degrees. Guards
    with infinite limits are skipped, except the guards of shape and of intersection.
    """
    reason = shape_refusal(state, star, floor, rise, limits.cosine, limits.longest)
    if reason != DONE:
        return reason
    grains = np.int64(0)
    if limits.drift < np.inf:
        grains = grain_cones(state, star, state.points[star.tip])
        if not drift_allows(state, grains, limits.drift):
            return VOLUME
    if limits.front_distance < np.inf and leaves_front(state, star, limits.front_distance):
        return DISTANCE
    if limits.crack_facets < np.inf and leaves_crack(state, star, limits.crack_facets):
        return DISTANCE
    loose = np.int64(0)
    if limits.distance < np.inf:
        loose = _set_loose(state, star)
        takers = _list_takers(state, star)
        if loose == TOO_MANY or takers < 0:
            return DISTANCE
        reaches = (limits.distance, limits.crack_distance, limits.front_distance)
        if not find_new_homes(state, star, loose, takers, reaches):
            return DISTANCE
    set_rows(state, star)
    near, sheet = _look_around(state, grid, star)
    if limits.wedge < np.inf and sharpens_wedge(state, star, sheet, limits.wedge):
        return WEDGE
    points, facets, corners = state.points, state.facets, state.star_corners
    alone = sheet.patch >= 0
    if near < 0 or star_intersects(grid, points, facets, near, corners, star.moved, alone):
        return INTERSECTION
    state.pending[0] = grains
    state.pending[1] = loose
    return DONE


@lean_kernel
def _set_loose(state, star):
    """List in state.loose the witnesses, initial vertex positions, that must find a new nearest facet.

    They are the witnesses of the star's old facets, and the vertices that move or are removed. Return the
    number of witnesses, or TOO_MANY.
    """
    count = 0
    for i in range(star.moved + star.dying):
        count = collect(state, old_facet(state, star, i), count)
        if count == TOO_MANY:
            return TOO_MANY
    near = state.dying[0] if star.dying > 0 else state.star[0]
    if star.tip != star.vertex:
        count = set_free(state, star.vertex, near, count)
    if star.gone >= 0:
        count = set_free(state, star.gone, near, count)
    return count


@lean_kernel
def _list_takers(state, star):
    """Return the number of facets in state.star that may get witnesses, or -1 if too many.

    Witnesses are initial vertex positions. If a vertex merges into a vertex that stays, the other facets at
    the staying vertex are appended to state.star, because they may get witnesses too.
    """
    if star.gone >= 0 and star.tip == star.vertex:
        return add_star(state, star.vertex, star.gone, star.vertex, star.moved)
    return star.moved


@lean_kernel
def _look_around(state, grid, star):
    """Return the number of facets in grid.candidate that new facets may meet, and the star's sheet.

    A sheet is a star that can only meet facets of other patches (`sheets`). The number is -1 if there are
    too many.
    """
    sheet = sheet_of(state, star)
    near = _list_near(state, grid, star, sheet)
    if sheet.patch >= 0 and near > 0:
        near = keep_foreign(state, grid, star, sheet, near)
    if sheet.patch >= 0 and near < 0:
        sheet = no_sheet()
        near = _list_near(state, grid, star, sheet)
    return near, sheet


@lean_kernel
def _list_near(state, grid, star, sheet):
    """List in grid.candidate the facets that may meet the star's new facets; return their number.

    These are facets whose bounds meet the bounds of the star, without the star's own. Grid cells whose
    facets all have the patch of `sheet` and similar normals are skipped. Return -1 if there are too many.
    """
    stamp, points = state.facet_stamp, state.points
    mark = state.clock[1] + 1
    state.clock[1] += 2
    for i in range(star.moved + star.dying):
        stamp[old_facet(state, star, i)] = mark + 1
    low = high = (points[star.tip, 0], points[star.tip, 1], points[star.tip, 2])
    for v in (star.vertex, star.gone if star.gone >= 0 else star.vertex):
        low, high = _with_point(low, high, points, v)
    for i in range(star.moved):
        for k in range(2):
            low, high = _with_point(low, high, points, state.star_ends[i, k])
    return gather_candidates(grid, points, state.facets, state.alive, stamp, mark, sheet, low, high)


@lean_kernel
def _with_point(low, high, points, v):
    """Return the bounds (low, high) enlarged by point `v`."""
    x, y, z = points[v, 0], points[v, 1], points[v, 2]
    low = (min(low[0], x), min(low[1], y), min(low[2], z))
    return low, (max(high[0], x), max(high[1], y), max(high[2], z))


@lean_kernel
def commit(state, grid, star):
    """Make the star's change, which `refusal` has just allowed."""
    book_drift(state, state.pending[0])
    for i in range(star.dying):
        _take_out(state, state.dying[i])
    for i in range(star.moved):
        _give_corners(state, star, i)
    v = star.vertex
    if star.tip != v:
        for k in range(3):
            state.points[v, k] = state.points[star.tip, k]
        state.size[v] = state.size[star.tip]
    if star.gone >= 0:
        state.rank[v] = max(state.rank[v], state.rank[star.gone])
        state.flags[v] |= state.flags[star.gone]
    attach_witnesses(state, state.pending[1])
    for i in range(star.moved):
        a, b, c = state.star_corners[i]
        insert_facet(grid, state.points, state.star[i], a, b, c, state.patch[state.star[i]])


@lean_kernel
def _take_out(state, f):
    """Remove facet `f` from the mesh."""
    state.alive[f] = False
    state.facet_stamp[f] = GONE
    state.witness_first[f] = -1
    for k in range(3):
        unlink_corner(state.first, state.after, state.facets[f, k], 3 * f + k)


@lean_kernel
def _give_corners(state, star, i):
    """Set the new corners of the star's facet in row `i`, and detach its witnesses, initial positions.

    At most one corner may differ from the old corners, except for the tip that stands for the vertex.
    """
    facets, f, v = state.facets, state.star[i], star.vertex
    state.changed[f] = True
    state.witness_first[f] = -1
    a, b, c = state.star_corners[i]
    # The sum of new corners minus the sum of old corners is the difference of the one corner that changes.
    change = a + b + c - star.tip + v - facets[f, 0] - facets[f, 1] - facets[f, 2]
    for k in range(3):
        old = facets[f, k]
        if old != v and old != a and old != b and old != c:
            replace_corner(state, f, k, old + change)


@lean_kernel
def replace_corner(state, f, k, v):
    """Set corner k of facet `f` to `v`, and update the corner lists."""
    unlink_corner(state.first, state.after, state.facets[f, k], 3 * f + k)
    state.facets[f, k] = v
    link_corner(state.first, state.after, v, 3 * f + k)
