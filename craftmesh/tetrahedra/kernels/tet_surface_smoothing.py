"""Moves of points within the surface that lower the mean aspect ratio of the tets of all grains."""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import whole_star, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import Cone
from craftmesh.tetrahedra.kernels.tet_faults import RAMP, SOUND_FROM, faults_at, faults_of
from craftmesh.tetrahedra.kernels.tet_quality import INVERTED, WHOLE
from craftmesh.tetrahedra.kernels.tet_ratio_sums import ratio_sum
from craftmesh.tetrahedra.kernels.tet_smoothing import (
    MOVE_FALL,
    PATTERN_STEP,
    ROUNDING,
    pattern_search,
    put_at,
    ratio_cone,
)


@lean_kernel
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
        step, far, limit = PATTERN_STEP * lengths[i], reach * lengths[i], worst - ROUNDING
        place, best = pattern_search(cone, ratios, place, first, ways[i], step, homes[i], far, limit)
        if best > first - MOVE_FALL:
            continue
        if worst < SOUND_FROM + RAMP:
            weight = faults_of(state, work.star, count)
            if faults_at(cone, place[0], place[1], place[2], INVERTED) > weight:
                continue
        put_at(state, v, place, count, WHOLE, work)
        moved += 1
    return moved
