"""Cavities round a poor tet, filled from one apex: a node nearby, or a new point.

This is for tets whose corners all lie on the surface, which often have no interior edge to remove and no
corner to move.
"""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import has_room, node_across, replace_cavity
from craftmesh.tetrahedra.kernels.tet_cone import Cone, beside
from craftmesh.tetrahedra.kernels.tet_insertion import add_apex
from craftmesh.tetrahedra.kernels.tet_quality import quality_at
from craftmesh.tetrahedra.kernels.tet_visible_cavity import best_cavity, list_outer_faces

# Search for the place of a new point: the first step in longest sides of the tet's box; how steps shrink;
# rounds. Starts at the centres of the tet and of its neighbours.
FIRST_STEP = 0.25
SHORTER = 0.5
ROUNDS = 8


@lean_kernel
def _node_near(state, t, way):
    """Return corner `way` of tet t or, from 4 on, the node across its face `way - 4`; -1 for none."""
    return state.tets[t, way] if way < 4 else node_across(state, t, way - 4)


@lean_kernel
def _fill(state, apex, size, measure, work):
    """Replace the cavity `work.star[:size]` by the tets from node `apex` to its outer faces."""
    points, faces = state.points, work.faces
    made = list_outer_faces(state, size, apex, work)
    x, y, z = points[apex, 0], points[apex, 1], points[apex, 2]
    for i in range(made):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        work.new[i, 0], work.new[i, 1], work.new[i, 2], work.new[i, 3] = a, b, c, apex
        work.new_quality[i] = quality_at(points, a, b, c, x, y, z, measure)
    replace_cavity(state, work.star, size, made, work)


@lean_kernel
def join_in_cavity(state, t, aim, work):
    """Fill a cavity with tet t from a node near it, if all new qualities exceed `aim.floor`."""
    points, best, apex = state.points, aim.floor, -1
    for way in range(8):
        node = _node_near(state, t, way)
        if node >= 0:
            place = (points[node, 0], points[node, 1], points[node, 2])
            value, size = best_cavity(state, t, node, place, aim.measure, work)
            if size > 0 and value > best:
                best, apex = value, node
    if apex < 0 or not has_room(state):
        return False
    place = (points[apex, 0], points[apex, 1], points[apex, 2])
    _, size = best_cavity(state, t, apex, place, aim.measure, work)
    _fill(state, apex, size, aim.measure, work)
    return True


@lean_kernel
def _centre(points, tet):
    x, y, z = 0.0, 0.0, 0.0
    for k in range(4):
        x += 0.25 * points[tet[k], 0]
        y += 0.25 * points[tet[k], 1]
        z += 0.25 * points[tet[k], 2]
    return x, y, z


@lean_kernel
def _longest_side(points, tet):
    """Longest side of the box round a tet."""
    longest = 0.0
    for k in range(3):
        low, high = points[tet[0], k], points[tet[0], k]
        for i in range(1, 4):
            low, high = min(low, points[tet[i], k]), max(high, points[tet[i], k])
        longest = max(longest, high - low)
    return longest


@lean_kernel
def _search(state, t, start, measure, work):
    """Walk along the axes while the best cavity round t gets better; return place and worst quality."""
    x, y, z = start
    step = FIRST_STEP * _longest_side(state.points, state.tets[t])
    best, _ = best_cavity(state, t, -1, start, measure, work)
    for _ in range(ROUNDS):
        found = False
        for way in range(6):
            px, py, pz = beside(x, y, z, way, step)
            value, _ = best_cavity(state, t, -1, (px, py, pz), measure, work)
            if value > best:
                x, y, z, best, found = px, py, pz, value, True
        if not found:
            step *= SHORTER
    return (x, y, z), best


@lean_kernel
def insert_in_cavity(state, t, aim, work):
    """Fill a cavity with tet t from a new point, if all exceed `aim.floor`; return the point or -1."""
    place, best = _search(state, t, _centre(state.points, state.tets[t]), aim.measure, work)
    for k in range(4):
        u = state.neighbours[t, k]
        if u >= 0:
            other, value = _search(state, t, _centre(state.points, state.tets[u]), aim.measure, work)
            if value > best:
                place, best = other, value
    _, size = best_cavity(state, t, -1, place, aim.measure, work)
    if size == 0 or best <= aim.floor or not has_room(state):
        return -1
    made = list_outer_faces(state, size, -1, work)
    total = 0.0
    for i in range(made):
        for k in range(3):
            total += state.size[work.faces[i, k]]
    cone = Cone(state.points, work.faces, made, aim.measure)
    node = add_apex(state, cone, place, total / (3 * made), work)
    replace_cavity(state, work.star, size, made, work)
    return node
