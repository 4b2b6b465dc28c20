"""The cavity that a given apex fills best: for flat tets that no other operation mends.

Seen from an apex, a cavity grows across its worst outer face until that face is on the surface. Every
cavity on the way is the smallest with its worst quality, so the best of them is the best that the apex can
do. Where the tets from an apex to all outer faces are positive, every ray from the apex leaves the cavity
once: they fill it. The one exception is a crack facet that holds the apex and lies within the cavity: its
two sides are outer faces on which no tet stands, and beside the crack front nothing else would keep it.
"""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import FACES, STAMP, face_key
from craftmesh.tetrahedra.kernels.tet_quality import quality_at

# Tets of a cavity at most: their faces fit the work arrays.
MAX_CAVITY = 80
# Quality at faces that hold the apex: no tet stands on them.
NO_TET = 1e300


@lean_kernel
def _is_other_side(state, work, count, u, k):
    """Whether an outer face is the other side of the blocked face opposite corner k of tet u."""
    for f in range(count):
        t, i = work.outer[f, 0], work.outer[f, 1]
        if work.outer[f, 2] < 0 and face_key(state.tets, t, i) == face_key(state.tets, u, k):
            return True
    return False


@lean_kernel
def _take(state, u, apex, place, measure, work, count):
    """Take tet u into the cavity; return the number of its outer faces, `count` before.

    -1 where both sides of a crack facet that holds the apex are in the cavity now.
    """
    tets, neighbours, mark = state.tets, state.neighbours, state.mark
    outer, quality = work.outer, work.outer_quality
    stamp = state.counts[STAMP]
    for k in range(4):
        beyond = neighbours[u, k]
        if beyond >= 0 and mark[beyond] == stamp:
            for f in range(count):
                if outer[f, 2] == u and outer[f, 0] == beyond:
                    count -= 1
                    for i in range(3):
                        outer[f, i] = outer[count, i]
                    quality[f] = quality[count]
                    break
            continue
        a, b, c = tets[u, FACES[k, 0]], tets[u, FACES[k, 1]], tets[u, FACES[k, 2]]
        outer[count, 0], outer[count, 1], outer[count, 2] = u, k, beyond
        quality[count] = NO_TET
        if a != apex and b != apex and c != apex:
            quality[count] = quality_at(state.points, a, b, c, place[0], place[1], place[2], measure)
        elif beyond < 0 and _is_other_side(state, work, count, u, k):
            return -1
        count += 1
    mark[u] = stamp
    return count


@lean_kernel
def best_cavity(state, first, apex, place, measure, work):
    """Grow the cavity from tet `first`; return its best worst quality and the number of its tets.

    apex: the node at `place`, or -1 for a new one. The cavity is `work.star[:number]`; 0 tets where the
    apex sees none whole.
    """
    cavity, outer, quality = work.star, work.outer, work.outer_quality
    state.counts[STAMP] += 1
    count = _take(state, first, apex, place, measure, work, 0)
    cavity[0] = first
    size, best, chosen = 1, 0.0, 0
    while True:
        worst, face = NO_TET, -1
        for f in range(count):
            if quality[f] < worst:
                worst, face = quality[f], f
        if worst > best and face >= 0:
            best, chosen = worst, size
        if face < 0 or outer[face, 2] < 0 or size == MAX_CAVITY:
            return best, chosen
        cavity[size] = outer[face, 2]
        size += 1
        count = _take(state, cavity[size - 1], apex, place, measure, work, count)
        if count < 0:
            return best, chosen


@lean_kernel
def list_outer_faces(state, size, apex, work):
    """List the outer faces without `apex` of the cavity `work.star[:size]`; retire all its nodes."""
    state.counts[STAMP] += 1
    stamp = state.counts[STAMP]
    tets, neighbours, mark, faces, made = state.tets, state.neighbours, state.mark, work.faces, 0
    for i in range(size):
        mark[work.star[i]] = stamp
    for i in range(size):
        t = work.star[i]
        for k in range(4):
            state.tet_of[tets[t, k]] = -1
            u = neighbours[t, k]
            if u >= 0 and mark[u] == stamp:
                continue
            for j in range(3):
                faces[made, j] = tets[t, FACES[k, j]]
            if faces[made, 0] != apex and faces[made, 1] != apex and faces[made, 2] != apex:
                made += 1
    return made
