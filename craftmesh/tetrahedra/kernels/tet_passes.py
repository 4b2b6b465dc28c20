"""Passes of the tetrahedral optimiser over many points or tets; `work.done` counts what they do."""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import POINTS, find_ring, find_star, worst_of
from craftmesh.tetrahedra.kernels.tet_cavity_filling import insert_in_cavity, join_in_cavity
from craftmesh.tetrahedra.kernels.tet_insertion import CLIMB_STEPS, contract, insert_on_edge
from craftmesh.tetrahedra.kernels.tet_lightening import lighten
from craftmesh.tetrahedra.kernels.tet_quality import Aim
from craftmesh.tetrahedra.kernels.tet_smoothing import smooth_aspect, smooth_worst
from craftmesh.tetrahedra.kernels.tet_sum_swaps import contract_for_sum, remove_edge_for_sum
from craftmesh.tetrahedra.kernels.tet_swaps import GAIN, remove_edge, remove_face

# What `work.done` counts.
MOVES, EDGE_REMOVALS, FACE_REMOVALS, CONTRACTIONS, INSERTIONS, JOINS = range(6)
# The worst quality has to rise by this much: an insertion costs elements. Chosen by hand.
INSERTION_GAIN = 0.01


@lean_kernel
def smooth_pass(state, aim, steps, selected, work):
    """Move each selected interior point once to raise its worst quality."""
    for v in range(state.counts[POINTS]):
        if selected[v] and not state.frozen[v] and state.tet_of[v] >= 0:
            work.done[MOVES] += smooth_worst(state, v, aim, steps, work)


@lean_kernel
def aspect_pass(state, aim, work):
    """Move each interior point once to lower the mean aspect ratio."""
    for v in range(state.counts[POINTS]):
        if not state.frozen[v] and state.tet_of[v] >= 0:
            work.done[MOVES] += smooth_aspect(state, v, aim, work)


@lean_kernel
def aspect_swap_pass(state, aim, order, work):
    """Remove an edge of each live tet in `order` if the sum of excesses falls by `aim.fall`."""
    for t in order:
        if state.tets[t, 0] < 0:
            continue
        for edge in range(6):
            if remove_edge_for_sum(state, t, edge, aim, work):
                work.done[EDGE_REMOVALS] += 1
                break


@lean_kernel
def aspect_contraction_pass(state, aim, order, work):
    """Contract each interior point in `order` if the sum of excesses falls by `aim.fall`."""
    for v in order:
        if not state.frozen[v] and state.tet_of[v] >= 0:
            work.done[CONTRACTIONS] += contract_for_sum(state, v, aim, work)


@lean_kernel
def _swap(state, t, measure, work):
    """Try to remove an edge, then a face of tet t."""
    for edge in range(6):
        if remove_edge(state, t, edge, measure, work):
            work.done[EDGE_REMOVALS] += 1
            return True
    for k in range(4):
        if remove_face(state, t, k, measure, work):
            work.done[FACE_REMOVALS] += 1
            return True
    return False


@lean_kernel
def _move(state, t, aim, work):
    """Try to lift tet t over the aim's floor by moving its corners."""
    for k in range(4):
        v = work.corners[k]
        if not state.frozen[v]:
            work.done[MOVES] += smooth_worst(state, v, aim, CLIMB_STEPS, work)
            if state.quality[t] >= aim.floor:
                return True
    return False


@lean_kernel
def _contract_any(state, measure, work):
    """Try to contract an interior corner of a tet into another one."""
    corners = work.corners
    for k in range(4):
        v = corners[k]
        if state.frozen[v]:
            continue
        worst = worst_of(state.quality, work.star, find_star(state, v, work.star))
        for j in range(4):
            if j != k and contract(state, v, corners[j], Aim(measure, worst + GAIN), work):
                work.done[CONTRACTIONS] += 1
                return True
    return False


@lean_kernel
def _insert_any(state, t, measure, work):
    """Try to insert a point on an interior edge of tet t."""
    for edge in range(6):
        count = find_ring(state, t, edge, work.ring, work.ring_tets)
        if count < 3:
            continue
        worst = worst_of(state.quality, work.ring_tets, count)
        node = insert_on_edge(state, t, edge, Aim(measure, worst + INSERTION_GAIN), work)
        if node >= 0:
            work.done[INSERTIONS] += 1
            smooth_worst(state, node, Aim(measure, 1.0), CLIMB_STEPS, work)
            return True
    return False


@lean_kernel
def _refill(state, t, measure, work):
    """Try to fill a cavity with tet t anew, from a node nearby, else from a new point."""
    if join_in_cavity(state, t, Aim(measure, state.quality[t] + GAIN), work):
        work.done[JOINS] += 1
        return True
    node = insert_in_cavity(state, t, Aim(measure, state.quality[t] + INSERTION_GAIN), work)
    if node >= 0:
        work.done[INSERTIONS] += 1
        smooth_worst(state, node, Aim(measure, 1.0), CLIMB_STEPS, work)
    return node >= 0


@lean_kernel
def repair_pass(state, aim, order, inserts, touched, work):
    """Repair the tets in `order` (worst first) that are under the floor by the first means that helps.

    `touched` marks the points of all tets looked at.
    """
    corners = work.corners
    for t in order:
        if state.tets[t, 0] < 0 or state.quality[t] >= aim.floor:
            continue
        for k in range(4):
            corners[k] = state.tets[t, k]
            touched[corners[k]] = True
        if (
            _swap(state, t, aim.measure, work)
            or _move(state, t, aim, work)
            or _contract_any(state, aim.measure, work)
        ):
            continue
        if inserts and not _insert_any(state, t, aim.measure, work):
            _refill(state, t, aim.measure, work)


@lean_kernel
def lighten_pass(state, aim, order, work):
    """Lower what the tets in `order` under the floor, and those round them, weigh; return the changes."""
    changes = 0
    for t in order:
        if state.tets[t, 0] >= 0 and state.quality[t] < aim.floor:
            changes += lighten(state, t, work)
    return changes
