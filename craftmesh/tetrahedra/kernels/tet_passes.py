"""Passes of the tetrahedral optimiser over many points or tets; `work.done` counts the operations."""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import KINDS, POINTS, TETS, list_stars
from craftmesh.tetrahedra.kernels.tet_objective import FAULTS
from craftmesh.tetrahedra.kernels.tet_operations import contract, insert_on_edge, remove_edge, remove_face
from craftmesh.tetrahedra.kernels.tet_smoothing import move_point, smooth_aspect

# Indices of the counts in `work.done`.
MOVES, EDGE_REMOVALS, FACE_REMOVALS, CONTRACTIONS, INSERTIONS = range(len(KINDS))


@lean_kernel
def smooth_pass(state, aim, selected, work):
    """Move each selected point once to raise its worst quality."""
    for v in range(state.counts[POINTS]):
        if selected[v] and not state.frozen[v] and state.tet_of[v] >= 0:
            work.done[MOVES] += move_point(state, v, aim, work)


@lean_kernel
def aspect_pass(state, aim, stars, work):
    """Move each point once to lower the mean aspect ratio; stars: see `list_stars`, which this fills."""
    first, corners = stars
    list_stars(state.tets, state.counts[TETS], state.frozen, first, corners)
    for v in range(state.counts[POINTS]):
        if first[v] < first[v + 1]:
            work.done[MOVES] += smooth_aspect(state, v, stars, aim, work)


@lean_kernel
def swap_pass(state, aim, order, work):
    """Remove an edge of each live tet in `order`, if that raises the aim's value."""
    for t in order:
        if state.tets[t, 0] >= 0:
            _remove_an_edge(state, t, aim, work)


@lean_kernel
def contraction_pass(state, aim, order, work):
    """Contract each interior point in `order`, if that raises the aim's value."""
    for v in order:
        if not state.frozen[v] and state.tet_of[v] >= 0:
            work.done[CONTRACTIONS] += contract(state, v, aim, work)


@lean_kernel
def _remove_an_edge(state, t, aim, work):
    for edge in range(6):
        if remove_edge(state, t, edge, aim, work):
            work.done[EDGE_REMOVALS] += 1
            return True
    return False


@lean_kernel
def _swap(state, t, aim, work):
    """Remove an edge, else a face of tet t; return whether one was removed."""
    if _remove_an_edge(state, t, aim, work):
        return True
    for k in range(4):
        if remove_face(state, t, k, aim, work):
            work.done[FACE_REMOVALS] += 1
            return True
    return False


@lean_kernel
def _move(state, t, aim, work):
    """Move corners of tet t until it exceeds the floor (FAULTS: until one moves); return success."""
    for k in range(4):
        v = work.corners[k]
        if not state.frozen[v] and move_point(state, v, aim, work):
            work.done[MOVES] += 1
            if aim.objective == FAULTS or state.quality[t] >= aim.floor:
                return True
    return False


@lean_kernel
def _contract_any(state, aim, work):
    """Contract an interior corner of the tet `work.corners`; return whether one was contracted."""
    for k in range(4):
        if not state.frozen[work.corners[k]] and contract(state, work.corners[k], aim, work):
            work.done[CONTRACTIONS] += 1
            return True
    return False


@lean_kernel
def _insert_any(state, t, aim, work):
    """Insert a point on an interior edge of tet t; return whether one was inserted."""
    for edge in range(6):
        node = insert_on_edge(state, t, edge, aim, work)
        if node >= 0:
            work.done[INSERTIONS] += 1
            return True
    return False


@lean_kernel
def improve(state, t, aim, inserts, work):
    """Improve tet t or its neighbours by the first operation that succeeds; return whether one did."""
    for k in range(4):
        work.corners[k] = state.tets[t, k]
    return (
        _swap(state, t, aim, work)
        or _move(state, t, aim, work)
        or _contract_any(state, aim, work)
        or (inserts and _insert_any(state, t, aim, work))
    )


@lean_kernel
def improve_pass(state, aim, order, inserts, touched, work):
    """Improve the tets in `order` that are under the floor; return the number of changes.

    touched (n,): becomes True at the corners of these tets.
    """
    changes = 0
    for t in order:
        if state.tets[t, 0] >= 0 and state.quality[t] < aim.floor:
            for k in range(4):
                touched[state.tets[t, k]] = True
            changes += improve(state, t, aim, inserts, work)
    return changes
