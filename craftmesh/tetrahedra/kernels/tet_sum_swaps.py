"""Removal of edges for a lower sum over the tets, where `tet_swaps` raises the worst quality.

The sum is the excess of aspect ratio over a reference, or what the tets at fault weigh (`tet_faults`). With
the mean of the mesh as reference, a fall of the excess lowers that mean, whatever the numbers of tets; a
2-3 swap of a face never lowered the excess in Delaunay meshes.
"""

from collections import namedtuple

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import (
    EDGES,
    find_ring,
    find_star,
    has_room,
    replace_cavity,
    worst_of,
)
from craftmesh.tetrahedra.kernels.tet_faults import fault_weight
from craftmesh.tetrahedra.kernels.tet_insertion import list_contraction
from craftmesh.tetrahedra.kernels.tet_quality import (
    INVERTED,
    VOLUME_LENGTH,
    WHOLE,
    aspect_ratio_of,
    aspect_ratio_over,
    quality_of,
)
from craftmesh.tetrahedra.kernels.tet_smoothing import LEAST_STAR
from craftmesh.tetrahedra.kernels.tet_swaps import MAX_RING_TO_REMOVE, list_triangulation

# A measure of quality, the value that new tets have to exceed, what the aspect ratio is reckoned from, and
# by how much the sum has to fall, less than 0 where it may rise; by WHOLE the faults are summed.
SumAim = namedtuple("SumAim", "measure floor reference fall")


@lean_kernel
def _sum_of(state, listed, count, aim):
    """Sum of the terms of the tets listed; the state's qualities are by the aim's measure."""
    tets, total = state.tets, 0.0
    for i in range(count):
        t = listed[i]
        corners = (tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3])
        total += _term(state.points, corners, state.quality[t], aim)
    return total


@lean_kernel
def _term(points, corners, quality, aim):
    """What a tet of a quality adds to the sum."""
    if aim.measure == WHOLE:
        return fault_weight(quality)
    a, b, c, d = corners
    return aspect_ratio_of(points, a, b, c, d) - aim.reference


@lean_kernel
def _sound_term(points, corners, aim):
    """What a tet adds to the sum; INVERTED if its quality is not over the floor."""
    a, b, c, d = corners
    if aim.measure == VOLUME_LENGTH:
        x, y, z = points[d, 0], points[d, 1], points[d, 2]
        ratio = aspect_ratio_over(points, a, b, c, x, y, z, aim.floor)
        return ratio - aim.reference if ratio < INVERTED else INVERTED
    quality = quality_of(points, a, b, c, d, aim.measure)
    return INVERTED if quality <= aim.floor else _term(points, corners, quality, aim)


@lean_kernel
def _best_triangulation(points, ends, count, aim, work):
    """Fill Klincsek's tables: least[i, k] = least sum over the ring's part i..k.

    It is INVERTED where no tets with qualities over `aim.floor` fill the part; split[i, k] is the apex of
    the triangle on i, k. Returns the sum over the whole ring, which lies round the edge between `ends`.
    """
    a, b = ends
    ring, least, split = work.ring, work.worst, work.split
    for i in range(count - 2, -1, -1):
        least[i, i + 1] = 0.0
        for k in range(i + 2, count):
            best, apex = INVERTED, -1
            for j in range(i + 1, k):
                value = least[i, j] + least[j, k]
                if value >= INVERTED:
                    continue
                value += _sound_term(points, (a, ring[i], ring[j], ring[k]), aim)
                if value >= INVERTED:
                    continue
                value += _sound_term(points, (ring[i], ring[j], ring[k], b), aim)
                if value < best:
                    best, apex = value, j
            least[i, k] = best
            split[i, k] = apex
    return least[0, count - 1]


@lean_kernel
def remove_edge_for_sum(state, t, edge, aim, work):
    """Remove an interior edge of tet t when the sum round it falls by `aim.fall`; return whether.

    All new qualities exceed the lesser of the worst before and `aim.floor`.
    """
    count = find_ring(state, t, edge, work.ring, work.ring_tets)
    if count < 3 or count > MAX_RING_TO_REMOVE or not has_room(state):
        return False
    ends = (state.tets[t, EDGES[edge, 0]], state.tets[t, EDGES[edge, 1]])
    limit = max(min(worst_of(state.quality, work.ring_tets, count), aim.floor), 0.0)
    before = _sum_of(state, work.ring_tets, count, aim)
    sound = SumAim(aim.measure, limit, aim.reference, aim.fall)
    least = _best_triangulation(state.points, ends, count, sound, work)
    if least >= INVERTED or least > before - aim.fall:
        return False
    made = list_triangulation(state.points, ends, count, aim.measure, work)
    replace_cavity(state, work.ring_tets, count, made, work)
    return True


@lean_kernel
def _excess(points, tets, count, reference):
    """Return the sum of aspect ratio less the reference over the first `count` tets."""
    total = 0.0
    for i in range(count):
        total += aspect_ratio_of(points, tets[i, 0], tets[i, 1], tets[i, 2], tets[i, 3]) - reference
    return total


@lean_kernel
def _list_neighbours(state, v, count, work):
    """List the points joined to v, `work.star[:count]` being its star, in `work.keys`; return how many."""
    found = 0
    for i in range(count):
        for k in range(4):
            w = state.tets[work.star[i], k]
            known = w == v
            for j in range(found):
                known = known or work.keys[j, 0] == w
            if not known:
                work.keys[found, 0] = w
                found += 1
    return found


@lean_kernel
def contract_for_sum(state, v, aim, work):
    """Contract interior point v to the neighbour with which the sum falls most; return whether.

    The sum is the excess of aspect ratio over `aim.reference`, and has to fall by `aim.fall`. All new
    qualities exceed `aim.floor`.
    """
    count = find_star(state, v, work.star)
    if count < LEAST_STAR or not has_room(state):
        return False
    for i in range(count):
        for k in range(4):
            work.new[i, k] = state.tets[work.star[i], k]
    least = _excess(state.points, work.new, count, aim.reference) - aim.fall
    best = -1
    for j in range(_list_neighbours(state, v, count, work)):
        made = list_contraction(state, v, work.keys[j, 0], count, aim, work)
        if made < 0:
            continue
        total = _excess(state.points, work.new, made, aim.reference)
        if total < least:
            best, least = work.keys[j, 0], total
    if best < 0:
        return False
    made = list_contraction(state, v, best, count, aim, work)
    state.tet_of[v] = -1
    replace_cavity(state, work.star, count, made, work)
    return True
