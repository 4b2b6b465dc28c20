"""Changes inside a grain that make flat, poor and stretched tets weigh less (`tet_faults`).

The same operations as those that raise the worst quality, which may leave it or lower it here; the state's
qualities are by WHOLE.
"""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import (
    MAX_FACES,
    find_ring,
    find_star,
    has_room,
    replace_cavity,
    star_faces,
)
from craftmesh.tetrahedra.kernels.tet_cone import Cone
from craftmesh.tetrahedra.kernels.tet_faults import (
    FALL,
    NO_TET,
    fault_weight,
    faults_at,
    faults_of,
    lightest_place,
)
from craftmesh.tetrahedra.kernels.tet_insertion import fill_ring, list_contraction, ring_cone
from craftmesh.tetrahedra.kernels.tet_quality import WHOLE, Aim
from craftmesh.tetrahedra.kernels.tet_smoothing import LEAST_STAR, put_at
from craftmesh.tetrahedra.kernels.tet_sum_swaps import SumAim, remove_edge_for_sum
from craftmesh.tetrahedra.kernels.tet_swaps import list_face_removal

# The weight has to fall by this much by an insertion: it costs elements.
INSERTION_FALL = 0.5
# An edge's removal has to lower the weight by this much.
REMOVAL_FALL = 0.01
# What all new tets exceed.
POSITIVE = Aim(WHOLE, 0.0)


@lean_kernel
def _weight_of_new(work, made):
    """Return what the new tets `work.new[:made]` weigh."""
    total = 0.0
    for i in range(made):
        total += fault_weight(work.new_quality[i])
    return total


@lean_kernel
def lighten_by_move(state, v, work):
    """Move interior point v to where its star weighs less; return whether."""
    count = find_star(state, v, work.star)
    if count < LEAST_STAR or count > MAX_FACES:
        return False
    before = faults_of(state, work.star, count)
    if before < FALL:
        return False
    points = state.points
    star_faces(state.tets, work.star, count, v, work.faces)
    cone = Cone(points, work.faces, count, WHOLE)
    place, after = lightest_place(cone, (points[v, 0], points[v, 1], points[v, 2]), state.size[v], before)
    if after > before - FALL:
        return False
    put_at(state, v, place, count, WHOLE, work)
    return True


@lean_kernel
def lighten_by_face(state, t, k, work):
    """Swap the two tets at the face opposite corner k of t for three that weigh less; return whether."""
    u = state.neighbours[t, k]
    if u < 0 or not list_face_removal(state, t, k, POSITIVE, work):
        return False
    before = fault_weight(state.quality[t]) + fault_weight(state.quality[u])
    if _weight_of_new(work, 3) > before - FALL:
        return False
    replace_cavity(state, work.ring_tets, 2, 3, work)
    return True


@lean_kernel
def lighten_by_contraction(state, v, w, work):
    """Contract interior point v to its neighbour w where its star weighs less then; return whether."""
    count = find_star(state, v, work.star)
    if count < LEAST_STAR or not has_room(state):
        return False
    made = list_contraction(state, v, w, count, POSITIVE, work)
    if made < 0 or _weight_of_new(work, made) > faults_of(state, work.star, count) - FALL:
        return False
    state.tet_of[v] = -1
    replace_cavity(state, work.star, count, made, work)
    return True


@lean_kernel
def lighten_by_insertion(state, t, edge, work):
    """Insert a point in the ring of an edge of tet t where that weighs less; return whether."""
    count = find_ring(state, t, edge, work.ring, work.ring_tets)
    if count < 3 or not has_room(state):
        return False
    limit = faults_of(state, work.ring_tets, count) - INSERTION_FALL
    cone, middle, half = ring_cone(state, t, edge, count, WHOLE, work)
    start = faults_at(cone, middle[0], middle[1], middle[2], NO_TET)
    if limit < 0.0 or start >= NO_TET:
        return False
    place, after = lightest_place(cone, middle, half, start)
    if after > limit:
        return False
    fill_ring(state, t, edge, count, cone, place, work)
    return True


@lean_kernel
def _contract_any(state, work):
    """Contract an interior corner of the tet `work.corners` into another one; return whether."""
    corners = work.corners
    for k in range(4):
        if state.frozen[corners[k]]:
            continue
        for j in range(4):
            if j != k and lighten_by_contraction(state, corners[k], corners[j], work):
                return True
    return False


@lean_kernel
def lighten(state, t, work):
    """Lower what tet t and those round it weigh by the first means that does; return whether."""
    for edge in range(6):
        if remove_edge_for_sum(state, t, edge, SumAim(WHOLE, 0.0, 0.0, REMOVAL_FALL), work):
            return True
    for k in range(4):
        if lighten_by_face(state, t, k, work):
            return True
    corners = work.corners
    for k in range(4):
        corners[k] = state.tets[t, k]
    for k in range(4):
        if not state.frozen[corners[k]] and lighten_by_move(state, corners[k], work):
            return True
    if _contract_any(state, work):
        return True
    for edge in range(6):
        if lighten_by_insertion(state, t, edge, work):
            return True
    return False
