"""Contraction of crowded interior points to lower the mean aspect ratio (`tet_sum_swaps` removes edges)."""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import find_star, has_room, replace_cavity
from craftmesh.tetrahedra.kernels.tet_insertion import list_contraction
from craftmesh.tetrahedra.kernels.tet_quality import aspect_ratio_of
from craftmesh.tetrahedra.kernels.tet_smoothing import LEAST_STAR


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
