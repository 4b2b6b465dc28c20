"""Moves of points, inside grains and on boundaries: worst tets, aspect ratios or faults get better."""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.surface.rounding import ROUNDING
from craftmesh.tetrahedra.kernels.tet_cavity import star_of, whole_star, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import ANYWHERE, FIRST_STEP, Cone, walk, worst_at
from craftmesh.tetrahedra.kernels.tet_objective import (
    FALL,
    FAULTS,
    GAIN,
    RAMP,
    RATIOS,
    SOUND_FROM,
    Aim,
    fault_weight,
    faults_at,
)
from craftmesh.tetrahedra.kernels.tet_quality import (
    FORM,
    INVERTED,
    POOR,
    WHOLE,
    WIDE,
    quality_of,
)
from craftmesh.tetrahedra.kernels.tet_ratio_sums import RatioCone, fill_table, ratio_sum

# Search for a lower aspect ratio: the first step in target lengths, and rounds. Of 560,000 tets the mean
# ends .001 higher with .05 and two rounds, .0004 lower with .12 and four, which take longer.
PATTERN_STEP = 0.08
PATTERN_ROUNDS = 3
# Tets of this quality by WHOLE are not under WIDE by FORM, and weigh nothing: the worst may fall to it.
FREE_FROM = POOR + WIDE


@lean_kernel
def _put_at(state, v, place, count, measure, work):
    """Move point v, of which `work.star` holds the star, and renew the qualities there."""
    state.points[v, 0], state.points[v, 1], state.points[v, 2] = place
    tets = state.tets
    for i in range(count):
        t = work.star[i]
        state.quality[t] = quality_of(state.points, tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3], measure)


@lean_kernel
def _pattern_search(cone, ratios, place, best, ways, step, home, reach, limit):
    """Walk along directions (k, 3) while the sum of aspect ratios falls; return the place and its sum.

    All places lie within `reach` of home, and there no tet's quality is under `limit`.
    """
    x, y, z = place
    for _ in range(PATTERN_ROUNDS):
        found = False
        for way in range(2 * len(ways)):
            a, b, c = ways[way // 2]
            d = step if way % 2 else -step
            px, py, pz = x + d * a, y + d * b, z + d * c
            if (px - home[0]) ** 2 + (py - home[1]) ** 2 + (pz - home[2]) ** 2 > reach * reach:
                continue
            value = ratio_sum(ratios, px, py, pz)
            if value < best - GAIN and worst_at(cone, px, py, pz, limit) > limit:
                x, y, z, best, found = px, py, pz, value, True
        if not found:
            step *= 0.5
    return (x, y, z), best


@lean_kernel
def _place_of_lower_ratios(state, v, count, aim, home, reach, ways, step, work):
    """Return a place of point v with a lower mean aspect ratio round it, and whether there is one.

    `work` holds its star of `count` tets and the faces opposite v, which stays within `reach` of `home` and
    goes along directions (k, 3). The worst quality stays over the lesser of itself and `aim.floor`.
    """
    points = state.points
    cone = Cone(points, work.faces, count, aim.measure)
    fill_table(points, work.faces, count, work.table)
    ratios = RatioCone(work.table, work.ratios, count)
    place = (points[v, 0], points[v, 1], points[v, 2])
    first = ratio_sum(ratios, place[0], place[1], place[2])
    if first >= INVERTED:
        return place, False
    limit = min(worst_of(state.quality, work.star, count), aim.floor) - ROUNDING
    place, best = _pattern_search(cone, ratios, place, first, ways, step, home, reach, limit)
    return place, best < first


@lean_kernel
def smooth_aspect(state, v, aim, work):
    """Move interior point v to where the mean aspect ratio round it is lower; return whether."""
    count = star_of(state, v, work)
    if count == 0:
        return False
    home = (state.points[v, 0], state.points[v, 1], state.points[v, 2])
    step = PATTERN_STEP * state.size[v]
    place, lower = _place_of_lower_ratios(state, v, count, aim, home, np.inf, ANYWHERE, step, work)
    if lower:
        _put_at(state, v, place, count, aim.measure, work)
    return lower


@lean_kernel
def weight_of(state, listed, count):
    """Return what the tets listed weigh by their faults; the state's qualities are by WHOLE."""
    total = 0.0
    for i in range(count):
        total += fault_weight(state.quality[listed[i]])
    return total


@lean_kernel
def _move_to_better(state, v, count, aim, home, reach, free, step, work):
    """Move point v to where its tets are worth more by the aim, WORST or FAULTS; return whether.

    `work` holds its star of `count` tets and the faces opposite v. v stays within `reach` of `home`; free
    (3, 3) makes of any step one that it may take; step: the first one's length.
    """
    points, lighter = state.points, aim.objective == FAULTS
    if lighter:
        before, enough, least = -weight_of(state, work.star, count), 0.0, FALL
    else:
        before, enough, least = worst_of(state.quality, work.star, count), aim.floor, GAIN
    if before > enough - least:
        return False
    cone = Cone(points, work.faces, count, aim.measure)
    place = (points[v, 0], points[v, 1], points[v, 2])
    place, best = walk(cone, place, step, (home, reach), free, (before, enough), lighter)
    if best < before + least:
        return False
    _put_at(state, v, place, count, aim.measure, work)
    return True


@lean_kernel
def move_inside(state, v, aim, work):
    """Move interior point v to where its tets are worth more by the aim; return whether."""
    count = star_of(state, v, work)
    home = (state.points[v, 0], state.points[v, 1], state.points[v, 2])
    step = FIRST_STEP * state.size[v]
    return count > 0 and _move_to_better(state, v, count, aim, home, np.inf, ANYWHERE, step, work)


@lean_kernel
def move_nodes(state, nodes, homes, reach, free, valence, aim, work):
    """Move nodes (k,) with a tet under `aim.floor` to better places by the aim; return how many moved.

    homes (k, 3): places of which they stay within `reach` (k,); free (k, 3, 3): what makes of any step one
    that they may take; valence (k,): how many tets are round each. The state holds these, linked across
    grain boundaries; a node whose tets do not follow each other over faces stays.
    """
    moved = 0
    for i in range(len(nodes)):
        count = whole_star(state, nodes[i], valence[i], work)
        home, step = (homes[i, 0], homes[i, 1], homes[i, 2]), FIRST_STEP * reach[i]
        moved += count > 0 and _move_to_better(
            state, nodes[i], count, aim, home, reach[i], free[i], step, work
        )
    return moved


@lean_kernel
def _is_narrower(points, v, place, count, work):
    """Tell whether node v in another place has a worse tet by FORM round it, and one under WIDE."""
    cone = Cone(points, work.faces, count, FORM)
    least = min(worst_at(cone, points[v, 0], points[v, 1], points[v, 2], -INVERTED), WIDE) - ROUNDING
    return worst_at(cone, place[0], place[1], place[2], least) < least


@lean_kernel
def smooth_on_surface(state, nodes, homes, ways, lengths, reach, valence, work):
    """Move nodes (k,) along two directions (k, 2, 3) to lower the mean aspect ratio; return how many moved.

    Round a node the worst quality by WHOLE falls to FREE_FROM at most, the worst by FORM to WIDE, and what
    its tets weigh does not rise (`tet_objective`).

    homes (k, 3): places of which they stay within the part `reach` of their lengths (k,); valence (k,): how
    many tets are round each. The state, its qualities by WHOLE, holds these, linked across grain
    boundaries; a node whose tets do not follow each other over faces stays.
    """
    points, moved, aim = state.points, 0, Aim(RATIOS, WHOLE, FREE_FROM, 0.0, 0.0)
    for i in range(len(nodes)):
        v = nodes[i]
        count = whole_star(state, v, valence[i], work)
        if not count:
            continue
        step, far = PATTERN_STEP * lengths[i], reach * lengths[i]
        place, lower = _place_of_lower_ratios(state, v, count, aim, homes[i], far, ways[i], step, work)
        if not lower:
            continue
        worst = worst_of(state.quality, work.star, count)
        if worst < FREE_FROM and _is_narrower(points, v, place, count, work):
            continue
        if worst < SOUND_FROM + RAMP:
            weight = weight_of(state, work.star, count)
            cone = Cone(points, work.faces, count, WHOLE)
            if faults_at(cone, place[0], place[1], place[2], INVERTED) > weight:
                continue
        _put_at(state, v, place, count, WHOLE, work)
        moved += 1
    return moved
