"""Passes of the tetrahedral optimiser over many points or tets."""

from numba import njit

from craftmesh.tetrahedra.kernels.tet_aspect_swaps import remove_edge_for_aspect
from craftmesh.tetrahedra.kernels.tet_cavity import POINTS, find_ring, find_star, worst_of
from craftmesh.tetrahedra.kernels.tet_cavity_insertion import insert_in_cavity
from craftmesh.tetrahedra.kernels.tet_insertion import contract, insert_on_edge
from craftmesh.tetrahedra.kernels.tet_smoothing import smooth_aspect, smooth_worst
from craftmesh.tetrahedra.kernels.tet_swaps import GAIN, remove_edge, remove_face

# What a pass counts: moves, edges removed, faces removed, contractions, insertions.
MOVES, EDGE_REMOVALS, FACE_REMOVALS, CONTRACTIONS, INSERTIONS = range(5)
CLIMB_STEPS = 8
# An insertion has to raise the worst quality by this much: it costs elements.
INSERTION_GAIN = 0.01


@njit(cache=True)
def smooth_pass(state, measure, threshold, steps, selected, work, operations):
    """Move each selected interior point once to raise its worst quality."""
    for v in range(state.counts[POINTS]):
        if selected[v] and not state.frozen[v] and state.tet_of[v] >= 0:
            operations[MOVES] += smooth_worst(state, v, measure, threshold, steps, work)


@njit(cache=True)
def aspect_pass(state, measure, floor, work, operations):
    """Move each interior point once to lower the mean aspect ratio."""
    for v in range(state.counts[POINTS]):
        if not state.frozen[v] and state.tet_of[v] >= 0:
            operations[MOVES] += smooth_aspect(state, v, measure, floor, work)


@njit(cache=True)
def aspect_swap_pass(state, measure, floor, reference, order, work, operations):
    """Remove an edge of each live tet in `order` if the sum of aspect ratio less `reference` falls."""
    for t in order:
        if state.tets[t, 0] < 0:
            continue
        for edge in range(6):
            if remove_edge_for_aspect(state, t, edge, measure, floor, reference, work):
                operations[EDGE_REMOVALS] += 1
                break


@njit(cache=True)
def _swap(state, t, measure, work, operations):
    """Try to remove an edge, then a face of tet t."""
    for edge in range(6):
        if remove_edge(state, t, edge, measure, work):
            operations[EDGE_REMOVALS] += 1
            return True
    for k in range(4):
        if remove_face(state, t, k, measure, work):
            operations[FACE_REMOVALS] += 1
            return True
    return False


@njit(cache=True)
def _move(state, t, measure, threshold, corners, work, operations):
    """Try to lift tet t over the threshold by moving its corners."""
    for k in range(4):
        if not state.frozen[corners[k]]:
            operations[MOVES] += smooth_worst(state, corners[k], measure, threshold, CLIMB_STEPS, work)
            if state.quality[t] >= threshold:
                return True
    return False


@njit(cache=True)
def _contract_any(state, measure, corners, work, operations):
    """Try to contract an interior corner of a tet into another one."""
    for k in range(4):
        v = corners[k]
        if state.frozen[v]:
            continue
        floor = worst_of(state.quality, work.star, find_star(state, v, work.star)) + GAIN
        for j in range(4):
            if j != k and contract(state, v, corners[j], measure, floor, work):
                operations[CONTRACTIONS] += 1
                return True
    return False


@njit(cache=True)
def _insert_any(state, t, measure, work, operations):
    """Try to insert a point on an interior edge of tet t."""
    for edge in range(6):
        count = find_ring(state, t, edge, work.ring, work.ring_tets)
        if count < 3:
            continue
        floor = worst_of(state.quality, work.ring_tets, count) + INSERTION_GAIN
        node = insert_on_edge(state, t, edge, measure, floor, CLIMB_STEPS, work)
        if node >= 0:
            operations[INSERTIONS] += 1
            smooth_worst(state, node, measure, 1.0, CLIMB_STEPS, work)
            return True
    return False


@njit(cache=True)
def repair_pass(state, measure, threshold, order, inserts, touched, work, operations):
    """Repair the tets in `order` (worst first) that are under `threshold` by the first means that helps.

    `touched` marks the points of all tets looked at.
    """
    corners = work.corners
    for t in order:
        if state.tets[t, 0] < 0 or state.quality[t] >= threshold:
            continue
        for k in range(4):
            corners[k] = state.tets[t, k]
            touched[corners[k]] = True
        if (
            _swap(state, t, measure, work, operations)
            or _move(state, t, measure, threshold, corners, work, operations)
            or _contract_any(state, measure, corners, work, operations)
        ):
            continue
        if inserts and not _insert_any(state, t, measure, work, operations) and state.quality[t] < 0.174:
            operations[INSERTIONS] += insert_in_cavity(state, t, measure, work) >= 0
