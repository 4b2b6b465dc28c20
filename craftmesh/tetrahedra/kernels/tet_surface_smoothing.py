"""Moves of points within the surface that lower the mean aspect ratio of the tets of all grains."""

from craftmesh.jit import kernel
from craftmesh.tetrahedra.kernels.tet_cavity import MAX_FACES, find_star, star_faces, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import Cone, aspect_sum, worst_at
from craftmesh.tetrahedra.kernels.tet_faults import RAMP, SOUND_FROM, faults_at, faults_of
from craftmesh.tetrahedra.kernels.tet_quality import INVERTED, WHOLE
from craftmesh.tetrahedra.kernels.tet_smoothing import (
    MOVE_FALL,
    PATTERN_ROUNDS,
    PATTERN_STEP,
    PLACE_FALL,
    ROUNDING,
    SHORTER,
    put_at,
)


@kernel
def _lowest_within(cone, place, best, home, ways, length, reach, limit):
    """Walk along two directions (2, 3) while the sum of aspect ratios falls; return the place and its sum.

    All places lie within `reach` of home, and there no tet's quality is under `limit`.
    """
    x, y, z = place
    step = PATTERN_STEP * length
    for _ in range(PATTERN_ROUNDS):
        found = False
        for way in range(4):
            d = step if way % 2 else -step
            a, b, c = ways[way // 2]
            px, py, pz = x + d * a, y + d * b, z + d * c
            if (px - home[0]) ** 2 + (py - home[1]) ** 2 + (pz - home[2]) ** 2 > reach * reach:
                continue
            value = aspect_sum(cone, px, py, pz, best)
            if value < best - PLACE_FALL and worst_at(cone, px, py, pz, limit) > limit:
                x, y, z, best, found = px, py, pz, value, True
        if not found:
            step *= SHORTER
    return (x, y, z), best


@kernel
def smooth_on_surface(state, nodes, homes, ways, lengths, reach, valence, work):
    """Move nodes (k,) along two directions (k, 2, 3) to lower the mean aspect ratio; return how many moved.

    The worst quality by WHOLE round a node does not fall, nor does what its tets weigh rise (`tet_faults`).

    homes (k, 3): places of which they stay within the part `reach` of their lengths (k,); valence (k,): how
    many tets are round each. The state, its qualities by WHOLE, holds these, linked across grain
    boundaries; a node whose tets do not follow each other over faces stays.
    """
    points, moved = state.points, 0
    for i in range(len(nodes)):
        v = nodes[i]
        count = find_star(state, v, work.star)
        if count != valence[i] or count > MAX_FACES:
            continue
        star_faces(state.tets, work.star, count, v, work.faces)
        cone = Cone(points, work.faces, count, WHOLE)
        place = (points[v, 0], points[v, 1], points[v, 2])
        first = aspect_sum(cone, place[0], place[1], place[2], INVERTED)
        if first >= INVERTED:
            continue
        worst = worst_of(state.quality, work.star, count)
        far = reach * lengths[i]
        place, best = _lowest_within(
            cone, place, first, homes[i], ways[i], lengths[i], far, worst - ROUNDING
        )
        if best > first - MOVE_FALL:
            continue
        if worst < SOUND_FROM + RAMP:
            weight = faults_of(state, work.star, count)
            if faults_at(cone, place[0], place[1], place[2], INVERTED) > weight:
                continue
        put_at(state, v, place, count, WHOLE, work)
        moved += 1
    return moved
