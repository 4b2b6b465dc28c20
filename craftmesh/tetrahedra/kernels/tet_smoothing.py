"""Moves of one interior point: to raise its worst tet, to lower its mean aspect ratio or its faults."""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.surface.rounding import ROUNDING
from craftmesh.tetrahedra.kernels.tet_cavity import MAX_FACES, find_star, star_faces, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import (
    ANYWHERE,
    INSIDE_STEP,
    Cone,
    climb,
    mean_at,
    walk,
    worst_at,
)
from craftmesh.tetrahedra.kernels.tet_objective import FALL, fault_weight
from craftmesh.tetrahedra.kernels.tet_operations import LEAST_STAR
from craftmesh.tetrahedra.kernels.tet_quality import INVERTED, VOLUME_LENGTH, WHOLE, quality_of
from craftmesh.tetrahedra.kernels.tet_ratio_sums import (
    RatioCone,
    fill_table,
    least_volume_length,
    mean_corner,
    ratio_sum,
)

# All numbers below are chosen by hand.
# A centroid may lower a sound worst quality by this factor when the mean rises by so much.
LOSS = 0.95
MEAN_GAIN = 1e-4
# The whole way to the centroid is tried, then half of it, and so on.
WAYS = 3
# A climb counts when it raises the worst quality by this much.
CLIMB_GAIN = 1e-6
# Search for a lower aspect ratio: the first step in target lengths; rounds; how steps shrink. With .12 and
# four rounds 560,000 tets take a tenth longer, and their mean ends .0004 lower; with .05 and two it ends
# .001 higher.
PATTERN_STEP = 0.08
PATTERN_ROUNDS = 3
SHORTER = 0.4
# A place has to lower the sum of aspect ratios by the first, the move as a whole by the second.
PLACE_FALL = 1e-6
MOVE_FALL = 1e-4


@lean_kernel
def put_at(state, v, place, count, measure, work):
    """Move point v, of which `work.star` holds the star, and renew the qualities there."""
    state.points[v, 0], state.points[v, 1], state.points[v, 2] = place
    tets = state.tets
    for i in range(count):
        t = work.star[i]
        state.quality[t] = quality_of(state.points, tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3], measure)


@lean_kernel
def _put_by_table(state, v, place, ratios, work):
    """Do as `put_at` for volume-length qualities, which the table gives at once."""
    state.points[v, 0], state.points[v, 1], state.points[v, 2] = place
    least_volume_length(ratios, place[0], place[1], place[2])
    for i in range(ratios.count):
        state.quality[work.star[i]] = ratios.values[i]


@lean_kernel
def _weighted_centroid(state, faces, count):
    """Centroid of the star's outer faces, weighted by area over target length cubed."""
    points, size = state.points, state.size
    cx, cy, cz, total = 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        weight = np.sqrt(nx * nx + ny * ny + nz * nz) / (size[a] + size[b] + size[c]) ** 3
        cx += weight * (points[a, 0] + points[b, 0] + points[c, 0]) / 3.0
        cy += weight * (points[a, 1] + points[b, 1] + points[c, 1]) / 3.0
        cz += weight * (points[a, 2] + points[b, 2] + points[c, 2]) / 3.0
        total += weight
    return cx / total, cy / total, cz / total


@lean_kernel
def _towards(cone, here, centroid, worst, threshold):
    """Return a better place on the way to the centroid, its worst quality, and whether there is one."""
    x0, y0, z0 = here
    cx, cy, cz = centroid
    floor = worst if worst < threshold else max(threshold, LOSS * worst)
    share = 1.0
    for _ in range(WAYS):
        px, py, pz = x0 + share * (cx - x0), y0 + share * (cy - y0), z0 + share * (cz - z0)
        value = worst_at(cone, px, py, pz, floor)
        if value > floor and (
            worst < threshold or mean_at(cone, px, py, pz) > mean_at(cone, x0, y0, z0) + MEAN_GAIN
        ):
            return (px, py, pz), value, True
        share *= 0.5
    return here, worst, False


@lean_kernel
def smooth_worst(state, v, aim, steps, work):
    """Move interior point v to raise its worst quality where that is under `aim.floor`; return whether.

    Elsewhere v goes towards the centroid of its star if the mean rises and the worst stays over both
    the floor and .95 of itself.
    """
    points, faces = state.points, work.faces
    count = find_star(state, v, work.star)
    if count < LEAST_STAR or count > MAX_FACES:
        return False
    star_faces(state.tets, work.star, count, v, faces)
    cone = Cone(points, faces, count, aim.measure)
    worst = worst_of(state.quality, work.star, count)
    here = (points[v, 0], points[v, 1], points[v, 2])
    place, best, moved = _towards(cone, here, _weighted_centroid(state, faces, count), worst, aim.floor)
    if best < aim.floor:
        climbed, value = climb(cone, place, state.size[v], steps, best)
        if value > best + CLIMB_GAIN:
            place, moved = climbed, True
    if moved:
        put_at(state, v, place, count, aim.measure, work)
    return moved


@lean_kernel
def ratio_cone(cone, work):
    """Return what the sums of the cone's aspect ratios are reckoned from, in `work`."""
    fill_table(cone.points, cone.faces, cone.count, work.table)
    return RatioCone(work.table, work.ratios, cone.count)


@lean_kernel
def _is_sound(cone, ratios, x, y, z, limit):
    """Tell whether all tets of the cone from (x, y, z) are of more quality than the limit."""
    if cone.measure == VOLUME_LENGTH:
        return least_volume_length(ratios, x, y, z) > limit
    return worst_at(cone, x, y, z, limit) > limit


@lean_kernel
def pattern_search(cone, ratios, place, best, ways, step, home, reach, limit):
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
            if value < best - PLACE_FALL and _is_sound(cone, ratios, px, py, pz, limit):
                x, y, z, best, found = px, py, pz, value, True
        if not found:
            step *= SHORTER
    return (x, y, z), best


@lean_kernel
def smooth_aspect(state, v, aim, work):
    """Lower the mean aspect ratio round interior point v by pattern search; return whether it moved.

    The worst quality stays over the lesser of itself and `aim.floor`.
    """
    points, faces = state.points, work.faces
    count = find_star(state, v, work.star)
    if count < LEAST_STAR or count > MAX_FACES:
        return False
    star_faces(state.tets, work.star, count, v, faces)
    cone = Cone(points, faces, count, aim.measure)
    limit = min(worst_of(state.quality, work.star, count), aim.floor) - ROUNDING
    place = (points[v, 0], points[v, 1], points[v, 2])
    ratios = ratio_cone(cone, work)
    first = ratio_sum(ratios, place[0], place[1], place[2])
    if first >= INVERTED:
        return False
    best = first
    px, py, pz = mean_corner(ratios)
    value = ratio_sum(ratios, px, py, pz)
    if value < best and _is_sound(cone, ratios, px, py, pz, limit):
        place, best = (px, py, pz), value
    step = PATTERN_STEP * state.size[v]
    place, best = pattern_search(cone, ratios, place, best, ANYWHERE, step, place, np.inf, limit)
    if best > first - MOVE_FALL:
        return False
    if aim.measure == VOLUME_LENGTH:
        _put_by_table(state, v, place, ratios, work)
    else:
        put_at(state, v, place, count, aim.measure, work)
    return True


@lean_kernel
def weight_of(state, listed, count):
    """Return what the tets listed weigh by their faults; the state's qualities are by WHOLE."""
    total = 0.0
    for i in range(count):
        total += fault_weight(state.quality[listed[i]])
    return total


@lean_kernel
def lighten_by_move(state, v, work):
    """Move interior point v to where its star weighs less; return whether."""
    count = find_star(state, v, work.star)
    if count < LEAST_STAR or count > MAX_FACES:
        return False
    before = weight_of(state, work.star, count)
    if before < FALL:
        return False
    points = state.points
    star_faces(state.tets, work.star, count, v, work.faces)
    cone = Cone(points, work.faces, count, WHOLE)
    place = (points[v, 0], points[v, 1], points[v, 2])
    step = INSIDE_STEP * state.size[v]
    place, value = walk(cone, place, step, (place, np.inf), ANYWHERE, (-before, 0.0), True)
    if value < FALL - before:
        return False
    put_at(state, v, place, count, WHOLE, work)
    return True
