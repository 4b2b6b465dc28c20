"""Passes of the tetrahedral optimiser over many points or tets; work.done counts the operations.

The aim has the objective, whose value over the changed tets must rise in each change, and the floor, the
quality under which a tet is improved (`tet_objective`). work: work arrays shared by the operations.
"""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import KINDS, POINTS, TETS, list_stars
from craftmesh.tetrahedra.kernels.tet_objective import FAULTS
from craftmesh.tetrahedra.kernels.tet_operations import contract, insert_on_edge, remove_edge, remove_face
from craftmesh.tetrahedra.kernels.tet_smoothing import move_point, smooth_aspect

# Indices of the counts in `work.done`.
MOVES, EDGE_REMOVALS, FACE_REMOVALS, CONTRACTIONS, INSERTIONS = range(len(KINDS))


@lean_kernel
def smooth_pass(state, aim, selected, work):
    """Try to move each selected point once, to raise the value of its tets by the aim's objective.

    selected (n,): mask. Frozen points and points without tets stay.
    """
    for v in range(state.counts[POINTS]):
        if selected[v] and not state.frozen[v] and state.tet_of[v] >= 0:
            work.done[MOVES] += move_point(state, v, aim, work)


@lean_kernel
def aspect_pass(state, aim, stars, work):
    """Try to move each point that is not frozen once, to lower the mean aspect ratio of its tets.

    stars: work arrays (n + 1,) and (4 t,) for the corners at each point, which this fills (`list_stars`).
    """
    first, corners = stars
    list_stars(state.tets, state.counts[TETS], state.frozen, first, corners)
    for v in range(state.counts[POINTS]):
        if first[v] < first[v + 1]:
            work.done[MOVES] += smooth_aspect(state, v, stars, aim, work)


@lean_kernel
def swap_pass(state, aim, order, work):
    """Remove one edge of each tet in `order` that still exists.

    It is the first of the tet's six edges whose removal raises the objective's value (aim.objective).
    """
    for t in order:
        if state.tets[t, 0] >= 0:
            _remove_an_edge(state, t, aim, work)


@lean_kernel
def contraction_pass(state, aim, order, work):
    """Merge each interior point in `order` into a neighbour, if that raises the value of their tets.

    The value is by the aim's objective. Frozen points stay.
    """
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
    """Move corners of tet t, each at most once, until its quality reaches aim.floor; return whether it did.

    For the objective FAULTS the first move that succeeds is enough.
    """
    for k in range(4):
        v = work.corners[k]
        if not state.frozen[v] and move_point(state, v, aim, work):
            work.done[MOVES] += 1
            if aim.objective == FAULTS or state.quality[t] >= aim.floor:
                return True
    return False


@lean_kernel
def _contract_any(state, aim, work):
    """Merge an interior node of work.corners into a neighbour; return whether one was merged.

    work.corners has the four nodes that the current tet had at the start.
    """
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
    """Improve tet t or its neighbours by the first operation that succeeds; return whether one did.

    The order is removal of an edge, removal of a face, moves of its corners, contraction of a corner into a
    neighbour, and, if `inserts`, insertion of a point on an edge.
    """
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
    """Improve the tets in `order` whose quality is under aim.floor; return the number of changes.

    inserts: whether a new point on an edge may be tried last. touched (n,): becomes True at the corners of
    these tets.
    """
    changes = 0
    for t in order:
        if state.tets[t, 0] >= 0 and state.quality[t] < aim.floor:
            for k in range(4):
                touched[state.tets[t, k]] = True
            changes += improve(state, t, aim, inserts, work)
    return changes
