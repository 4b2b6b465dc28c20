"""Moves of nodes on grain boundaries: for flat tets that the surface forces, seen by all grains at once."""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import whole_star, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import Cone, walk, worst_at
from craftmesh.tetrahedra.kernels.tet_objective import FALL, FAULTS, GAIN, RAMP, SOUND_FROM, faults_at
from craftmesh.tetrahedra.kernels.tet_quality import FORM, INVERTED, POOR, WHOLE, WIDE
from craftmesh.tetrahedra.kernels.tet_ratio_sums import ratio_sum
from craftmesh.tetrahedra.kernels.tet_smoothing import (
    MOVE_FALL,
    PATTERN_STEP,
    ROUNDING,
    pattern_search,
    put_at,
    ratio_cone,
    weight_of,
)

# The first step of a move in parts of the reach.
FIRST_STEP = 0.5


@lean_kernel
def move_nodes(state, nodes, homes, reach, free, valence, aim, work):
    """Move nodes (k,) with a tet under `aim.floor` to better places by the aim; return how many moved.

    homes (k, 3): places of which they stay within `reach` (k,); free (k, 3, 3): what makes of any step one
    that they may take; valence (k,): how many tets are round each. The state holds these, linked across
    grain boundaries; a node whose tets do not follow each other over faces stays.
    """
    points, moved, lighter = state.points, 0, aim.objective == FAULTS
    for i in range(len(nodes)):
        v = nodes[i]
        count = whole_star(state, v, valence[i], work)
        if not count:
            continue
        if lighter:
            before, enough, least = -weight_of(state, work.star, count), 0.0, FALL
        else:
            before, enough, least = worst_of(state.quality, work.star, count), aim.floor, GAIN
        if before >= enough:
            continue
        cone = Cone(points, work.faces, count, aim.measure)
        place = (points[v, 0], points[v, 1], points[v, 2])
        home = (homes[i, 0], homes[i, 1], homes[i, 2])
        step, disc = FIRST_STEP * reach[i], (home, reach[i])
        place, best = walk(cone, place, step, disc, free[i], (before, enough), lighter)
        if best < before + least:
            continue
        put_at(state, v, place, count, aim.measure, work)
        moved += 1
    return moved


# Tets of this quality by WHOLE are not under WIDE by FORM, and weigh nothing: the worst may fall to it.
# Where it may not fall at all, the mean aspect ratio of 360,000 and 560,000 tets is .003 and .004 higher.
FREE_FROM = POOR + WIDE


@lean_kernel
def _is_narrower(points, v, place, count, work):
    """Tell whether node v in another place has a worse tet by FORM round it, and one under WIDE."""
    cone = Cone(points, work.faces, count, FORM)
    least = min(worst_at(cone, points[v, 0], points[v, 1], points[v, 2], -INVERTED), WIDE) - ROUNDING
    return worst_at(cone, place[0], place[1], place[2], least) < least


@lean_kernel
def add_edges(points, tets, total, count):
    """Add the length of each edge of tets (m, 4) to `total` (n,) at both ends, and one to `count` (n,)."""
    for t in range(len(tets)):
        for i in range(3):
            a = tets[t, i]
            for j in range(i + 1, 4):
                b = tets[t, j]
                x, y = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
                z = points[b, 2] - points[a, 2]
                length = np.sqrt(x * x + y * y + z * z)
                total[a] += length
                total[b] += length
                count[a] += 1
                count[b] += 1


@lean_kernel
def smooth_on_surface(state, nodes, homes, ways, lengths, reach, valence, work):
    """Move nodes (k,) along two directions (k, 2, 3) to lower the mean aspect ratio; return how many moved.

    Round a node the worst quality by WHOLE falls to FREE_FROM at most, the worst by FORM to WIDE, and what
    its tets weigh does not rise (`tet_objective`).

    homes (k, 3): places of which they stay within the part `reach` of their lengths (k,); valence (k,): how
    many tets are round each. The state, its qualities by WHOLE, holds these, linked across grain
    boundaries; a node whose tets do not follow each other over faces stays.
    """
    points, moved = state.points, 0
    for i in range(len(nodes)):
        v = nodes[i]
        count = whole_star(state, v, valence[i], work)
        if not count:
            continue
        cone = Cone(points, work.faces, count, WHOLE)
        place = (points[v, 0], points[v, 1], points[v, 2])
        ratios = ratio_cone(cone, work)
        first = ratio_sum(ratios, place[0], place[1], place[2])
        if first >= INVERTED:
            continue
        worst = worst_of(state.quality, work.star, count)
        step, far, limit = PATTERN_STEP * lengths[i], reach * lengths[i], min(worst, FREE_FROM) - ROUNDING
        place, best = pattern_search(cone, ratios, place, first, ways[i], step, homes[i], far, limit)
        if best > first - MOVE_FALL:
            continue
        if worst < FREE_FROM and _is_narrower(points, v, place, count, work):
            continue
        if worst < SOUND_FROM + RAMP:
            weight = weight_of(state, work.star, count)
            if faults_at(cone, place[0], place[1], place[2], INVERTED) > weight:
                continue
        put_at(state, v, place, count, WHOLE, work)
        moved += 1
    return moved
