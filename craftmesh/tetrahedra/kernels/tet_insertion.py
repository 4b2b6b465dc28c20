"""Interior points that go or come: contraction of an edge, and insertion on one."""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import (
    EDGES,
    POINTS,
    find_ring,
    find_star,
    has_room,
    replace_cavity,
)
from craftmesh.tetrahedra.kernels.tet_cone import Cone, climb, worst_at
from craftmesh.tetrahedra.kernels.tet_quality import quality_at, quality_of
from craftmesh.tetrahedra.kernels.tet_smoothing import LEAST_STAR

# Contraction makes no edge longer than this many target lengths; chosen by hand.
LONGEST = 1.6
# Steps of the climb for the new point's place.
CLIMB_STEPS = 8


@lean_kernel
def _distance(points, a, b):
    return np.sqrt(
        (points[a, 0] - points[b, 0]) ** 2
        + (points[a, 1] - points[b, 1]) ** 2
        + (points[a, 2] - points[b, 2]) ** 2
    )


@lean_kernel
def list_contraction(state, v, w, count, aim, work):
    """Write the tets that join the outer faces of v's star (`work.star[:count]`) to w; return their number.

    It is -1 where a new quality does not exceed `aim.floor`, or a new edge is too long.
    """
    points, tets, size = state.points, state.tets, state.size
    made = 0
    for i in range(count):
        t = work.star[i]
        if tets[t, 0] == w or tets[t, 1] == w or tets[t, 2] == w or tets[t, 3] == w:
            continue
        for k in range(4):
            node = tets[t, k]
            if node == v:
                node = w
            elif _distance(points, node, w) > LONGEST * 0.5 * (size[node] + size[w]):
                return -1
            work.new[made, k] = node
        new = work.new[made]
        work.new_quality[made] = quality_of(points, new[0], new[1], new[2], new[3], aim.measure)
        if work.new_quality[made] <= max(aim.floor, 0.0):
            return -1
        made += 1
    return made


@lean_kernel
def contract(state, v, w, aim, work):
    """Remove the interior point v by joining its star's outer faces to its neighbour w; return whether.

    Done when all new qualities exceed `aim.floor` and no new edge is too long.
    """
    count = find_star(state, v, work.star)
    if count < LEAST_STAR or not has_room(state):
        return False
    made = list_contraction(state, v, w, count, aim, work)
    if made < 0:
        return False
    state.tet_of[v] = -1
    replace_cavity(state, work.star, count, made, work)
    return True


@lean_kernel
def add_apex(state, cone, place, size, work):
    """Add a point with the target length `size` at `place` and write the cone's tets; return its id.

    The caller has checked that there is room, and replaces the cavity under the cone.
    """
    node = state.counts[POINTS]
    state.counts[POINTS] += 1
    x, y, z = place
    state.points[node, 0], state.points[node, 1], state.points[node, 2] = x, y, z
    state.size[node] = size
    state.frozen[node] = False
    faces = cone.faces
    for i in range(cone.count):
        for k in range(3):
            work.new[i, k] = faces[i, k]
        work.new[i, 3] = node
        work.new_quality[i] = quality_at(
            state.points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, cone.measure
        )
    return node


@lean_kernel
def ring_cone(state, t, edge, count, measure, work):
    """Return the cone from an edge of tet t to the outer faces of its ring, `work.ring[:count]`.

    The middle of the edge and half its length come with it.
    """
    points, faces = state.points, work.faces
    a, b = state.tets[t, EDGES[edge, 0]], state.tets[t, EDGES[edge, 1]]
    for i in range(count):
        c, d = work.ring[i], work.ring[(i + 1) % count]
        faces[2 * i, 0], faces[2 * i, 1], faces[2 * i, 2] = a, c, d
        faces[2 * i + 1, 0], faces[2 * i + 1, 1], faces[2 * i + 1, 2] = b, d, c
    x = 0.5 * (points[a, 0] + points[b, 0])
    y = 0.5 * (points[a, 1] + points[b, 1])
    z = 0.5 * (points[a, 2] + points[b, 2])
    cone = Cone(points, faces, 2 * count, measure)
    return cone, (x, y, z), 0.5 * _distance(points, a, b)


@lean_kernel
def fill_ring(state, t, edge, count, cone, place, work):
    """Replace the ring of an edge of tet t by the cone from a new point at `place`; return its id."""
    a, b = state.tets[t, EDGES[edge, 0]], state.tets[t, EDGES[edge, 1]]
    node = add_apex(state, cone, place, 0.5 * (state.size[a] + state.size[b]), work)
    replace_cavity(state, work.ring_tets, count, 2 * count, work)
    return node


@lean_kernel
def insert_on_edge(state, t, edge, aim, work):
    """Insert a point in the ring of an interior edge of tet t; return its id, or -1 if not done.

    It goes to the best place that a climb from the edge's middle finds; done when the worst new
    quality exceeds `aim.floor`.
    """
    count = find_ring(state, t, edge, work.ring, work.ring_tets)
    if count < 3 or not has_room(state):
        return -1
    cone, middle, half = ring_cone(state, t, edge, count, aim.measure, work)
    worst = worst_at(cone, middle[0], middle[1], middle[2], 0.0)
    if worst <= 0.0:
        return -1
    place, worst = climb(cone, middle, half, CLIMB_STEPS, worst)
    if worst <= aim.floor:
        return -1
    return fill_ring(state, t, edge, count, cone, place, work)
