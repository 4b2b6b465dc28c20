"""Moves of points inside grains and on boundaries, for worst quality, aspect ratios or fault weight.

A point stays within `reach` of its `home` and moves along the rows of `ways` (3, 3), its bounds in the
state. The star of a point is the set of tets with this corner.
"""

from craftmesh.jit import lean_kernel
from craftmesh.surface.rounding import ROUNDING
from craftmesh.tetrahedra.kernels.tet_cavity import listed_star, star_of, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import FIRST_STEP, Cone, walk
from craftmesh.tetrahedra.kernels.tet_objective import FALL, FAULTS, GAIN, fault_weight
from craftmesh.tetrahedra.kernels.tet_quality import FLAT, INVERTED, POOR, VOLUME_LENGTH, WIDE, quality_of
from craftmesh.tetrahedra.kernels.tet_ratio_sums import RatioCone, fill_table, ratio_sum

# Search for a lower aspect ratio: first step in target lengths, halved each iteration; number of
# iterations; largest move to the minimum of a parabola through three points, in steps. 190,000 tets of 24
# grains end with a mean aspect ratio of 1.6817; with a first step of .05 it is 1.6823, with one iteration
# 1.6857, with moves of at most one step 1.6828.
PATTERN_STEP = 0.08
PATTERN_ROUNDS = 2
MOST_STEPS = 2.0
# Quality by COMBINED_QUALITY to which the worst tet may fall: such tets are not under WIDE by
# SHAPE_QUALITY, and their fault weight is 0.
FREE_FROM = POOR + WIDE


@lean_kernel
def _put_at(state, v, place, count, measure, limit, work):
    """Move point v to `place` and update the qualities of its tets work.star[:count]; return True.

    If a quality would not exceed `limit`, v stays and the result is False.
    """
    points, tets = state.points, state.tets
    before = (points[v, 0], points[v, 1], points[v, 2])
    points[v, 0], points[v, 1], points[v, 2] = place
    for i in range(count):
        t = work.star[i]
        work.new_quality[i] = quality_of(points, tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3], measure)
        if work.new_quality[i] <= limit:
            points[v, 0], points[v, 1], points[v, 2] = before
            return False
    for i in range(count):
        state.quality[work.star[i]] = work.new_quality[i]
    return True


@lean_kernel
def _way_down(ratios, place, first, ways, step):
    """Return the move (3,) to the minima of parabolas along the directions `ways` (k, 3).

    Each parabola interpolates the sum of aspect ratios a step behind, at and ahead of `place`; first: the
    sum at `place`.
    """
    x, y, z = place
    dx = dy = dz = 0.0
    for way in range(len(ways)):
        a, b, c = step * ways[way, 0], step * ways[way, 1], step * ways[way, 2]
        if a == b == c == 0.0:
            continue
        ahead, behind = ratio_sum(ratios, x + a, y + b, z + c), ratio_sum(ratios, x - a, y - b, z - c)
        steps = 0.5 * (behind - ahead) / max(ahead + behind - 2.0 * first, GAIN)
        steps = min(max(steps, -MOST_STEPS), MOST_STEPS)
        dx, dy, dz = dx + steps * a, dy + steps * b, dz + steps * c
    return dx, dy, dz


@lean_kernel
def _pattern_search(ratios, place, best, ways, step, home, reach):
    """Move along directions `ways` (k, 3) while the sum of aspect ratios falls; return position and sum.

    ratios: the cone, whose tets are summed; best: the sum at `place`. All positions lie within `reach` of
    `home`. A move that does not help is tried once more at half length.
    """
    for _ in range(PATTERN_ROUNDS):
        x, y, z = place
        dx, dy, dz = _way_down(ratios, place, best, ways, step)
        found = False
        for part in (1.0, 0.5):
            px, py, pz = x + part * dx, y + part * dy, z + part * dz
            if (px - home[0]) ** 2 + (py - home[1]) ** 2 + (pz - home[2]) ** 2 > reach * reach:
                continue
            value = ratio_sum(ratios, px, py, pz)
            if value < best - GAIN:
                place, best, found = (px, py, pz), value, True
                break
        if not found:
            break
        step *= 0.5
    return place, best


@lean_kernel
def smooth_aspect(state, v, stars, aim, work):
    """Move point v, within its bounds, if the mean aspect ratio of its tets falls; return whether it moved.

    No quality of these tets falls below aim.floor, or below their worst one before if that is less. stars:
    the corners at each point, from `list_stars`.
    """
    count = listed_star(state.tets, stars, v, work)
    if count == 0:
        return False
    points, own = state.points, min(v, len(state.reach) - 1)
    limit = min(worst_of(state.quality, work.star, count), aim.floor) - ROUNDING
    fill_table(points, work.faces, count, work.table)
    least = max(limit, FLAT) if aim.measure == VOLUME_LENGTH else FLAT
    ratios = RatioCone(work.table, work.ratios, count, least)
    place = (points[v, 0], points[v, 1], points[v, 2])
    first = ratio_sum(ratios, place[0], place[1], place[2])
    if first >= INVERTED:
        return False
    home, reach = (state.home[own, 0], state.home[own, 1], state.home[own, 2]), state.reach[own]
    step = PATTERN_STEP * state.size[v]
    place, best = _pattern_search(ratios, place, first, state.ways[own], step, home, reach)
    return best < first and _put_at(state, v, place, count, aim.measure, limit, work)


@lean_kernel
def weight_of(state, listed, count):
    """Return the fault weight, a penalty on flat, poor and stretched tets, of the tets listed[:count].

    state.quality must be by COMBINED_QUALITY.
    """
    total = 0.0
    for i in range(count):
        total += fault_weight(state.quality[listed[i]])
    return total


@lean_kernel
def _move_to_better(state, v, count, aim, home, reach, ways, step, work):
    """Move point v if the value of its tets rises; return whether it moved.

    The value is their worst quality for the objective WORST, else minus their fault weight (FAULTS). `work`
    has v's star of `count` tets and the faces opposite v. v stays within `reach` of `home` and moves
    along the rows of ways (3, 3); step: length of the first step.
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
    place, best = walk(cone, place, step, (home, reach), ways, (before, enough), lighter)
    return best >= before + least and _put_at(state, v, place, count, aim.measure, -INVERTED, work)


@lean_kernel
def move_point(state, v, aim, work):
    """Move point v, within its bounds, if the value of its tets rises; return whether it moved.

    The value is by the aim's objective, WORST or FAULTS. The bounds are in state.reach and state.ways.
    """
    count, own = star_of(state, v, work), min(v, len(state.reach) - 1)
    home, reach = (state.home[own, 0], state.home[own, 1], state.home[own, 2]), state.reach[own]
    step = FIRST_STEP * min(state.size[v], reach)
    return count > 0 and _move_to_better(state, v, count, aim, home, reach, state.ways[own], step, work)
