"""Moves of points, inside grains and on boundaries: worst tets, aspect ratios or faults get better."""

from craftmesh.jit import lean_kernel
from craftmesh.surface.rounding import ROUNDING
from craftmesh.tetrahedra.kernels.tet_cavity import star_of, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import FIRST_STEP, Cone, walk, worst_at
from craftmesh.tetrahedra.kernels.tet_objective import FALL, FAULTS, GAIN, fault_weight
from craftmesh.tetrahedra.kernels.tet_quality import INVERTED, POOR, WIDE, quality_of
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
            if a == b == c == 0.0:
                continue
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
    """Move point v, within its bounds, to where the mean aspect ratio round it is lower; return whether."""
    count = star_of(state, v, work)
    if count == 0:
        return False
    own, step = min(v, len(state.reach) - 1), PATTERN_STEP * state.size[v]
    home = (state.home[own, 0], state.home[own, 1], state.home[own, 2])
    place, lower = _place_of_lower_ratios(
        state, v, count, aim, home, state.reach[own], state.ways[own], step, work
    )
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
def _move_to_better(state, v, count, aim, home, reach, ways, step, work):
    """Move point v to where its tets are worth more by the aim, WORST or FAULTS; return whether.

    `work` holds its star of `count` tets and the faces opposite v. v stays within `reach` of `home` and
    goes along the rows of ways (3, 3); step: the first one's length.
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
    if best < before + least:
        return False
    _put_at(state, v, place, count, aim.measure, work)
    return True


@lean_kernel
def move_point(state, v, aim, work):
    """Move point v, within its bounds, to where its tets are worth more by the aim; return whether."""
    count, own = star_of(state, v, work), min(v, len(state.reach) - 1)
    home, reach = (state.home[own, 0], state.home[own, 1], state.home[own, 2]), state.reach[own]
    step = FIRST_STEP * min(state.size[v], reach)
    return count > 0 and _move_to_better(state, v, count, aim, home, reach, state.ways[own], step, work)
