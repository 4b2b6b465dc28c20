"""Swaps: removal of an edge by the best triangulation of its ring (Klincsek), and of a face by 2-3 swap."""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import (
    EDGES,
    FACES,
    find_ring,
    has_room,
    node_across,
    replace_cavity,
    worst_of,
)
from craftmesh.tetrahedra.kernels.tet_quality import Aim, quality_of

# Rings of more tets are left: the work grows with the cube of their number.
MAX_RING_TO_REMOVE = 8
# The worst quality has to rise by this much, so that rounding starts no endless swaps; chosen by hand.
GAIN = 1e-4


@lean_kernel
def _best_triangulation(points, ends, count, aim, work):
    """Fill Klincsek's tables: worst[i, k] = best attainable worst quality of the ring's part i..k.

    Parts that cannot exceed `aim.floor` get -1; split[i, k] is the apex of the triangle on i, k. Returns
    the value of the whole ring, which lies round the edge between `ends`.
    """
    a, b = ends
    ring, worst, split = work.ring, work.worst, work.split
    measure, floor = aim.measure, aim.floor
    for i in range(count - 2, -1, -1):
        worst[i, i + 1] = 1e300
        for k in range(i + 2, count):
            best, apex = -1.0, -1
            for j in range(i + 1, k):
                value = min(worst[i, j], worst[j, k])
                if value <= max(best, floor):
                    continue
                value = min(value, quality_of(points, a, ring[i], ring[j], ring[k], measure))
                if value <= max(best, floor):
                    continue
                value = min(value, quality_of(points, ring[i], ring[j], ring[k], b, measure))
                if value > max(best, floor):
                    best, apex = value, j
            worst[i, k] = best
            split[i, k] = apex
    return worst[0, count - 1]


@lean_kernel
def list_triangulation(points, ends, count, measure, work):
    """Write the tets of the triangulation that `work.split` describes; return their number."""
    a, b = ends
    ring, split, stack, new, new_quality = work.ring, work.split, work.stack, work.new, work.new_quality
    stack[0, 0], stack[0, 1] = 0, count - 1
    height, made = 1, 0
    while height > 0:
        height -= 1
        i, k = stack[height, 0], stack[height, 1]
        if k - i < 2:
            continue
        j = split[i, k]
        new[made, 0], new[made, 1], new[made, 2], new[made, 3] = a, ring[i], ring[j], ring[k]
        new_quality[made] = quality_of(points, a, ring[i], ring[j], ring[k], measure)
        made += 1
        new[made, 0], new[made, 1], new[made, 2], new[made, 3] = ring[i], ring[j], ring[k], b
        new_quality[made] = quality_of(points, ring[i], ring[j], ring[k], b, measure)
        made += 1
        stack[height, 0], stack[height, 1] = i, j
        stack[height + 1, 0], stack[height + 1, 1] = j, k
        height += 2
    return made


@lean_kernel
def remove_edge(state, t, edge, measure, work):
    """Remove an interior edge of tet t when that raises the worst quality round it; return whether."""
    count = find_ring(state, t, edge, work.ring, work.ring_tets)
    if count < 3 or count > MAX_RING_TO_REMOVE or not has_room(state):
        return False
    ends = (state.tets[t, EDGES[edge, 0]], state.tets[t, EDGES[edge, 1]])
    aim = Aim(measure, worst_of(state.quality, work.ring_tets, count) + GAIN)
    if _best_triangulation(state.points, ends, count, aim, work) <= max(aim.floor, 0.0):
        return False
    made = list_triangulation(state.points, ends, count, measure, work)
    replace_cavity(state, work.ring_tets, count, made, work)
    return True


@lean_kernel
def list_face_removal(state, t, k, aim, work):
    """Write the three tets for the two at the face opposite corner k of t; return whether that can be done.

    All their qualities exceed `aim.floor`.
    """
    r = node_across(state, t, k)
    if r < 0 or not has_room(state):
        return False
    tets, new = state.tets, work.new
    p = tets[t, k]
    for i in range(3):
        x, y = tets[t, FACES[k, i]], tets[t, FACES[k, (i + 1) % 3]]
        new[i, 0], new[i, 1], new[i, 2], new[i, 3] = r, p, x, y
        work.new_quality[i] = quality_of(state.points, r, p, x, y, aim.measure)
        if work.new_quality[i] <= aim.floor:
            return False
    work.ring_tets[0], work.ring_tets[1] = t, state.neighbours[t, k]
    return True


@lean_kernel
def remove_face(state, t, k, measure, work):
    """Swap the two tets at the face opposite corner k of t for three if the worst rises; return whether."""
    u = state.neighbours[t, k]
    if u < 0:
        return False
    worst = min(state.quality[t], state.quality[u])
    if not list_face_removal(state, t, k, Aim(measure, max(worst + GAIN, 0.0)), work):
        return False
    replace_cavity(state, work.ring_tets, 2, 3, work)
    return True
