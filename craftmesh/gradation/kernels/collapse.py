"""Edge collapse on multi-material surfaces: checks first, each with its reason, then the change."""

import numpy as np
from numba import njit

from craftmesh.gradation.kernels.codes import (
    DISTANCE,
    DONE,
    EAR,
    GRAIN_CONTACT,
    INTERSECTION,
    LINK,
    ON_CRACK,
    VOLUME,
    counted,
    is_held,
)
from craftmesh.gradation.kernels.collapse_rules import (
    EITHER,
    NEITHER,
    ONTO_A,
    ONTO_B,
    closes_thin_end,
    grains_touch,
    link_refusal,
    makes_ear,
    movable_end,
)
from craftmesh.gradation.kernels.cones import book_drift, drift_allows, grain_cones, volume_shift
from craftmesh.gradation.kernels.facet_grid import GONE, has_room
from craftmesh.gradation.kernels.rings import has_corner, is_feature, link_corner, unlink_corner
from craftmesh.gradation.kernels.star import add_star, enter_star, hits, shape_refusal, worst_score
from craftmesh.gradation.kernels.witnesses import TOO_MANY, collect, find_new_homes, set_free, settle
from craftmesh.surface.kernels.facet_shape import squared_distance


@njit(cache=True)
def _add_dying(state, a, b):
    facets, after, dying = state.facets, state.after, state.dying
    count = 0
    c = state.first[b]
    while c >= 0:
        if has_corner(facets, c // 3, a):
            if count >= len(dying):
                return -1
            dying[count] = c // 3
            count += 1
        c = after[c]
    return count


@njit(cache=True)
def _collect_loose(state, moved, dying, a, b, halfway):
    """List the witnesses that the collapse sets free, the ends' own homes among them."""
    count = 0
    for i in range(moved + dying):
        count = collect(state, state.star[i] if i < moved else state.dying[i - moved], count)
        if count == TOO_MANY:
            return TOO_MANY
    if halfway:
        count = set_free(state, a, state.dying[0], count)
    return set_free(state, b, state.dying[0], count)


@njit(cache=True)
def _new_place(state, a, b, moved, dying, place):
    """Set `place` to the middle of the edge, moved so that the grains keep their volumes."""
    for k in range(3):
        place[k] = 0.5 * (state.points[a, k] + state.points[b, k])
    planes = state.flags[a]
    shift = np.empty(3)
    volume_shift(state, grain_cones(state, moved, dying, place), planes, shift)
    reach = 0.3 * np.sqrt(squared_distance(state.points, a, b)) + 0.05 * state.size[a]
    length = np.sqrt(shift[0] ** 2 + shift[1] ** 2 + shift[2] ** 2)
    if length > reach:
        shift *= reach / length
    for k in range(3):
        if is_held(planes, k):
            place[k] = state.points[a, k]
        else:
            place[k] += shift[k]


@njit(cache=True)
def merge(state, a, b, dying):
    """Put the facets of `b` on `a` and take out the dying ones."""
    facets, first, after = state.facets, state.first, state.after
    for i in range(dying):
        f = state.dying[i]
        state.alive[f] = False
        state.facet_stamp[f] = GONE
        state.witness_first[f] = -1
        for k in range(3):
            unlink_corner(first, after, facets[f, k], 3 * f + k)
    c = first[b]
    while c >= 0:
        following = after[c]
        facets[c // 3, c % 3] = a
        link_corner(first, after, a, c)
        c = following
    first[b] = -1
    state.rank[a] = max(state.rank[a], state.rank[b])
    state.flags[a] |= state.flags[b]


@njit(cache=True)
def collapse(state, grid, limits, a, b, halfway):
    """Merge `b` into `a`, at a's place or halfway where the volumes are kept; return DONE or why not.

    The link condition must hold already (link_refusal).
    """
    points = state.points
    if makes_ear(state, a, b):
        return EAR
    dying = _add_dying(state, a, b)
    moved = add_star(state, b, a, a, np.int64(0))
    if halfway and moved >= 0:
        moved = add_star(state, a, b, a, moved)
    if dying < 0 or moved < 0:
        return LINK
    place = np.empty(3)
    if halfway:
        _new_place(state, a, b, moved, dying, place)
    else:
        place[:] = points[a]
    floor = min(limits.floor, worst_score(state, moved, dying) + limits.gain)
    before = points[a].copy()
    size = state.size[a]
    rows = grain_cones(state, moved, dying, place)
    if not drift_allows(state, rows, limits.drift):
        return VOLUME
    points[a] = place
    if halfway:
        state.size[a] = 0.5 * (size + state.size[b])
    reason = shape_refusal(state, moved, a, floor, limits.cosine, limits.longest)
    loose = 0
    if reason == DONE:
        loose = _collect_loose(state, moved, dying, a, b, halfway)
        total = moved if halfway else add_star(state, a, b, a, moved)
        if loose == TOO_MANY or total < 0:
            reason = DISTANCE
        elif not find_new_homes(state, loose, total, limits.distance, state.size[a], limits.crack_distance):
            reason = DISTANCE
    if reason == DONE and hits(state, grid, moved, dying):
        reason = INTERSECTION
    if reason != DONE:
        points[a] = before
        state.size[a] = size
        return reason
    book_drift(state, rows)
    for i in range(moved):
        state.witness_first[state.star[i]] = -1
    merge(state, a, b, dying)
    settle(state, loose)
    enter_star(state, grid, moved)
    return DONE


@njit(cache=True)
def collapse_edge(state, grid, limits, a, b):
    """Collapse edge (a, b) when its vertex classes and the topology allow it; return DONE or why not."""
    lines = state.rank[a] > 0 and state.rank[b] > 0
    feature = lines and is_feature(state.facets, state.patch, state.first, state.after, a, b)
    closing = limits.merge_points and lines and not feature and closes_thin_end(state, a, b)
    ends, reason = movable_end(
        state.rank[a],
        state.rank[b],
        state.flags[a],
        state.flags[b],
        feature or closing,
        limits.merge_points,
    )
    if ends == NEITHER:
        return reason
    reason = link_refusal(state, a, b, closing, limits.merge_points)
    if reason != DONE:
        return reason
    if (closing or (state.rank[a] == 2 and state.rank[b] == 2)) and grains_touch(state, a, b):
        return GRAIN_CONTACT
    reason = _collapse_somehow(state, grid, limits, a, b, ends)
    if closing and reason == DONE:
        state.rank[a if state.first[b] < 0 else b] = 2
    return reason


@njit(cache=True)
def _collapse_somehow(state, grid, limits, a, b, ends):
    """Collapse the edge halfway or onto an end that stays, whichever suits; return DONE or why not."""
    reason = DONE
    if ends == EITHER and not (state.flags[a] & ON_CRACK):
        reason = collapse(state, grid, limits, a, b, np.bool_(True))
        if reason == DONE:
            return DONE
    if ends != ONTO_B:
        reason = collapse(state, grid, limits, a, b, np.bool_(False))
    if ends != ONTO_A and reason != DONE:
        reason = collapse(state, grid, limits, b, a, np.bool_(False))
    return reason


@njit(cache=True)
def collapse_pass(state, grid, limits, edges, order, start):
    """Collapse edges under limits.collapse of their target, in `order` from `start` on.

    Returns where it stopped (len(order), or earlier when the grid must be rebuilt) and how many it
    collapsed.
    """
    done = 0
    for n in range(start, len(order)):
        if not has_room(grid):
            return n, done
        a = edges[order[n], 0]
        b = edges[order[n], 1]
        if state.first[a] < 0 or state.first[b] < 0:
            continue
        limit = limits.collapse * 0.5 * (state.size[a] + state.size[b])
        if squared_distance(state.points, a, b) >= limit * limit:
            continue
        done += counted(state.refused, collapse_edge(state, grid, limits, a, b))
    return len(order), done
