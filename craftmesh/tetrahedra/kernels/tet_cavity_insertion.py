"""Insertion of a point in a cavity grown round a poor tet, for tets whose corners all lie on the surface.

Such tets often have no interior edge to remove and no corner to move: a point behind them is what helps.
"""

from craftmesh.jit import kernel
from craftmesh.tetrahedra.kernels.tet_cavity import FACES, STAMP, has_room, replace_cavity, worst_of
from craftmesh.tetrahedra.kernels.tet_cone import Cone, climb, worst_at
from craftmesh.tetrahedra.kernels.tet_insertion import add_apex

# Tets of a cavity at most, and steps of the climb for each cavity that is tried; chosen by hand.
MAX_CAVITY = 14
CLIMB_STEPS = 12
# The worst quality has to rise by this much: an insertion costs elements.
INSERTION_GAIN = 0.01


@kernel
def _outer_faces(state, count, work):
    """Write the outer faces of the cavity, positive towards its inside; return their number."""
    state.counts[STAMP] += 1
    stamp = state.counts[STAMP]
    cavity, faces = work.star, work.faces
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


@kernel
def _longest_side(points, tet):
    """Longest side of the box round a tet."""
    longest = 0.0
    for k in range(3):
        low, high = points[tet[0], k], points[tet[0], k]
        for i in range(1, 4):
            low, high = min(low, points[tet[i], k]), max(high, points[tet[i], k])
        longest = max(longest, high - low)
    return longest


@kernel
def _best_apex(state, count, measure, work):
    """Return the best place found for a cone over the outer faces of the cavity, and its worst quality."""
    points, tets, cavity = state.points, state.tets, work.star
    cone = Cone(points, work.faces, _outer_faces(state, count, work), measure)
    x, y, z = 0.0, 0.0, 0.0
    for i in range(count):
        for k in range(4):
            node = tets[cavity[i], k]
            x += points[node, 0] / (4.0 * count)
            y += points[node, 1] / (4.0 * count)
            z += points[node, 2] / (4.0 * count)
    worst = worst_at(cone, x, y, z, -1e300)
    return climb(cone, (x, y, z), _longest_side(points, tets[cavity[0]]), CLIMB_STEPS, worst)


@kernel
def _swallows(state, count, made, work):
    """Whether a corner of the cavity's tets is on none of its outer faces."""
    cavity, faces = work.star, work.faces
    for i in range(count):
        for k in range(4):
            node = state.tets[cavity[i], k]
            found = False
            for j in range(made):
                found |= faces[j, 0] == node or faces[j, 1] == node or faces[j, 2] == node
            if not found:
                return True
    return False


@kernel
def _is_in(cavity, count, t):
    for i in range(count):
        if cavity[i] == t:
            return True
    return False


@kernel
def _grow(state, count, measure, work):
    """Add to the cavity the neighbour with which its best cone is best; return place and worst quality.

    Where there is none to add, -1 is added.
    """
    cavity = work.star
    best, chosen, place = -1e300, -1, (0.0, 0.0, 0.0)
    for i in range(count):
        for k in range(4):
            u = state.neighbours[cavity[i], k]
            if u < 0 or _is_in(cavity, count, u):
                continue
            cavity[count] = u
            trial, value = _best_apex(state, count + 1, measure, work)
            if value > best:
                best, chosen, place = value, u, trial
    cavity[count] = chosen
    return place, best


@kernel
def insert_in_cavity(state, t, measure, work):
    """Replace tet t and some tets round it by a cone from a new point; return its id, or -1 if not done.

    Done when the worst quality rises. No corner of the tets gets lost.
    """
    cavity = work.star
    cavity[0] = t
    best, size, place = 0.0, 0, (0.0, 0.0, 0.0)
    for count in range(1, MAX_CAVITY):
        apex, value = _grow(state, count, measure, work)
        if cavity[count] < 0:
            break
        floor = worst_of(state.quality, cavity, count + 1) + INSERTION_GAIN
        if value > max(best, floor):
            best, size, place = value, count + 1, apex
    if size == 0 or not has_room(state):
        return -1
    made = _outer_faces(state, size, work)
    if _swallows(state, size, made, work):
        return -1
    total = 0.0
    for i in range(made):
        for k in range(3):
            total += state.size[work.faces[i, k]]
    cone = Cone(state.points, work.faces, made, measure)
    node = add_apex(state, cone, place, total / (3 * made), work)
    replace_cavity(state, cavity, size, made, work)
    return node
