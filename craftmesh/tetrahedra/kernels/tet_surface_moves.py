"""Moves of nodes on grain boundaries: for flat tets that the surface forces, seen by all grains at once."""

from itertools import product

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import whole_star, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import Cone, worst_at
from craftmesh.tetrahedra.kernels.tet_faults import FALL, RAMP, SOUND_FROM, faults_at, faults_of
from craftmesh.tetrahedra.kernels.tet_quality import FORM, INVERTED, POOR, WHOLE, WIDE
from craftmesh.tetrahedra.kernels.tet_ratio_sums import ratio_sum
from craftmesh.tetrahedra.kernels.tet_smoothing import (
    MOVE_FALL,
    PATTERN_STEP,
    ROUNDING,
    pattern_search,
    put_at,
    ratio_cone,
)

# The first step of a move in parts of the reach; how steps shrink; rounds.
FIRST_STEP = 0.5
SHORTER = 0.5
ROUNDS = 10
# The worst quality has to rise by this much.
GAIN = 1e-4
# Unit steps along the axes, the diagonals of faces, and those of the cube.
_STEPS = np.array([step for step in product((-1.0, 0.0, 1.0), repeat=3) if any(step)])
DIRECTIONS = _STEPS / np.linalg.norm(_STEPS, axis=1, keepdims=True)


@lean_kernel
def _goal(cone, x, y, z, best, lighter):
    """Worst quality of the cone from (x, y, z), or what it weighs, negative; exact where over `best`."""
    return -faults_at(cone, x, y, z, -best) if lighter else worst_at(cone, x, y, z, best)


@lean_kernel
def _walk(cone, place, home, reach, free, span, lighter):
    """Walk while the goal rises, up to the end of `span`; return place and goal.

    All places lie within `reach` of home; free (3, 3) makes of each step one that is allowed.
    """
    x, y, z = place
    best, enough = span
    step = FIRST_STEP * reach
    for _ in range(ROUNDS):
        found = False
        for way in range(len(DIRECTIONS)):
            dx, dy, dz = DIRECTIONS[way]
            px = x + step * (free[0, 0] * dx + free[0, 1] * dy + free[0, 2] * dz)
            py = y + step * (free[1, 0] * dx + free[1, 1] * dy + free[1, 2] * dz)
            pz = z + step * (free[2, 0] * dx + free[2, 1] * dy + free[2, 2] * dz)
            if (px - home[0]) ** 2 + (py - home[1]) ** 2 + (pz - home[2]) ** 2 > reach * reach:
                continue
            value = _goal(cone, px, py, pz, best, lighter)
            if value > best + GAIN:
                x, y, z, best, found = px, py, pz, value, True
                if best >= enough:
                    return (x, y, z), best
        if not found:
            step *= SHORTER
    return (x, y, z), best


@lean_kernel
def move_nodes(state, nodes, homes, reach, free, valence, aim, lighter, work):
    """Move nodes (k,) with a tet under `aim.floor` to where the worst is better; return how many moved.

    lighter: to where their tets weigh less by their faults; the qualities are by WHOLE then.

    homes (k, 3): places of which they stay within `reach` (k,); free (k, 3, 3): what makes of any step one
    that they may take; valence (k,): how many tets are round each. The state holds these, linked across
    grain boundaries; a node whose tets do not follow each other over faces stays.
    """
    points, moved = state.points, 0
    for i in range(len(nodes)):
        v = nodes[i]
        count = whole_star(state, v, valence[i], work)
        if not count:
            continue
        if lighter:
            before, enough, least = -faults_of(state, work.star, count), 0.0, FALL
        else:
            before, enough, least = worst_of(state.quality, work.star, count), aim.floor, GAIN
        if before >= enough:
            continue
        cone = Cone(points, work.faces, count, aim.measure)
        place = (points[v, 0], points[v, 1], points[v, 2])
        place, best = _walk(cone, place, homes[i], reach[i], free[i], (before, enough), lighter)
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
    its tets weigh does not rise (`tet_faults`).

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
            weight = faults_of(state, work.star, count)
            if faults_at(cone, place[0], place[1], place[2], INVERTED) > weight:
                continue
        put_at(state, v, place, count, WHOLE, work)
        moved += 1
    return moved
