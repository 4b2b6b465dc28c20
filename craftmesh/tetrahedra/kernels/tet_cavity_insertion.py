"""Insertion of a point in a cavity grown round a poor tet, for tets whose corners all lie on the surface.

Such tets often have no interior edge to remove and no corner to move: a point behind them is what helps.
"""

import numpy as np
from numba import njit

from craftmesh.tetrahedra.kernels.tet_cavity import FACES, POINTS, STAMP, has_room, replace_cavity, worst_of
from craftmesh.tetrahedra.kernels.tet_quality import quality_at
from craftmesh.tetrahedra.kernels.tet_smoothing import climb, worst_at

MAX_CAVITY = 14
CLIMB_STEPS = 12
# The worst quality has to rise by this much: an insertion costs elements.
GAIN = 0.01


@njit(cache=True)
def _outer_faces(state, cavity, count, faces):
    """Write the outer faces of the cavity, positive towards its inside; return their number."""
    state.counts[STAMP] += 1
    stamp = state.counts[STAMP]
    for i in range(count):
        state.mark[cavity[i]] = stamp
    made = 0
    for i in range(count):
        t = cavity[i]
        for k in range(4):
            u = state.neighbours[t, k]
            if u < 0 or state.mark[u] != stamp:
                for j in range(3):
                    faces[made, j] = state.tets[t, FACES[k, j]]
                made += 1
    return made


@njit(cache=True)
def _best_apex(state, cavity, count, measure, work, apex):
    """Set `apex` to the best place found for a cone over the outer faces; return its worst quality."""
    made = _outer_faces(state, cavity, count, work.faces)
    points, tets = state.points, state.tets
    apex[:] = 0.0
    for i in range(count):
        for k in range(4):
            apex += points[tets[cavity[i], k]] / (4.0 * count)
    x, y, z = apex
    worst = worst_at(points, work.faces, made, x, y, z, measure, -1e300)
    longest = 0.0
    for k in range(3):
        longest = max(longest, np.ptp(points[tets[cavity[0]], k]))
    x, y, z, worst = climb(points, work.faces, made, x, y, z, longest, measure, CLIMB_STEPS, worst)
    apex[0], apex[1], apex[2] = x, y, z
    return worst


@njit(cache=True)
def _swallows(state, cavity, count, faces, made):
    """Whether a corner of the cavity's tets is on none of its outer faces."""
    for i in range(count):
        for k in range(4):
            found = False
            for j in range(made):
                node = state.tets[cavity[i], k]
                found |= faces[j, 0] == node or faces[j, 1] == node or faces[j, 2] == node
            if not found:
                return True
    return False


@njit(cache=True)
def _grow(state, cavity, count, measure, work, apex, trial):
    """Add to the cavity the neighbour with which its best cone is best; return that worst quality."""
    best, chosen = -1e300, -1
    for i in range(count):
        for k in range(4):
            u = state.neighbours[cavity[i], k]
            if u < 0 or (cavity[:count] == u).any():
                continue
            cavity[count] = u
            value = _best_apex(state, cavity, count + 1, measure, work, trial)
            if value > best:
                best, chosen = value, u
                apex[:] = trial
    cavity[count] = chosen
    return best


@njit(cache=True)
def insert_in_cavity(state, t, measure, work):
    """Replace tet t and some tets round it by a cone from a new point; return its id, or -1 if not done.

    Done when the worst quality rises. No corner of the tets gets lost.
    """
    cavity = work.star
    cavity[0] = t
    apex, trial, chosen = np.empty(3), np.empty(3), np.empty(3)
    best, size = 0.0, 0
    for count in range(1, MAX_CAVITY):
        value = _grow(state, cavity, count, measure, work, apex, trial)
        if cavity[count] < 0:
            break
        floor = worst_of(state.quality, cavity, count + 1) + GAIN
        if value > max(best, floor):
            best, size = value, count + 1
            chosen[:] = apex
    if size == 0 or not has_room(state):
        return -1
    faces = work.faces
    made = _outer_faces(state, cavity, size, faces)
    if _swallows(state, cavity, size, faces, made):
        return -1
    node = state.counts[POINTS]
    state.counts[POINTS] += 1
    state.points[node] = chosen
    state.frozen[node] = False
    total = 0.0
    for i in range(made):
        for k in range(3):
            work.new[i, k] = faces[i, k]
            total += state.size[faces[i, k]]
        work.new[i, 3] = node
        work.new_quality[i] = quality_at(
            state.points, faces[i, 0], faces[i, 1], faces[i, 2], chosen[0], chosen[1], chosen[2], measure
        )
    state.size[node] = total / (3 * made)
    replace_cavity(state, cavity, size, made, work)
    return node
