"""Interior points that go or come: contraction of an edge, and insertion on one."""

import numpy as np
from numba import njit

from craftmesh.tetrahedra.kernels.tet_cavity import (
    EDGES,
    POINTS,
    find_ring,
    find_star,
    has_room,
    replace_cavity,
)
from craftmesh.tetrahedra.kernels.tet_quality import quality_at, quality_of
from craftmesh.tetrahedra.kernels.tet_smoothing import climb, worst_at

# Contraction makes no edge longer than this many target lengths.
LONGEST = 1.6


@njit(cache=True)
def _distance(points, a, b):
    return np.sqrt(
        (points[a, 0] - points[b, 0]) ** 2
        + (points[a, 1] - points[b, 1]) ** 2
        + (points[a, 2] - points[b, 2]) ** 2
    )


@njit(cache=True)
def contract(state, v, w, measure, floor, work):
    """Remove the interior point v by joining its star's outer faces to its neighbour w; return whether.

    Done when all new qualities exceed `floor` and no new edge is too long.
    """
    count = find_star(state, v, work.star)
    if count < 4 or not has_room(state):
        return False
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
                return False
            work.new[made, k] = node
        new = work.new[made]
        work.new_quality[made] = quality_of(points, new[0], new[1], new[2], new[3], measure)
        if work.new_quality[made] <= max(floor, 0.0):
            return False
        made += 1
    state.tet_of[v] = -1
    replace_cavity(state, work.star, count, made, work)
    return True


@njit(cache=True)
def insert_on_edge(state, t, edge, measure, floor, steps, work):
    """Insert a point in the ring of an interior edge of tet t; return its id, or -1 if not done.

    It goes to the best place that a climb from the edge's middle finds; done when the worst new
    quality exceeds `floor`.
    """
    count = find_ring(state, t, edge, work.ring, work.ring_tets)
    if count < 3 or not has_room(state):
        return -1
    points, faces = state.points, work.faces
    a, b = state.tets[t, EDGES[edge, 0]], state.tets[t, EDGES[edge, 1]]
    for i in range(count):
        c, d = work.ring[i], work.ring[(i + 1) % count]
        faces[2 * i, 0], faces[2 * i, 1], faces[2 * i, 2] = a, c, d
        faces[2 * i + 1, 0], faces[2 * i + 1, 1], faces[2 * i + 1, 2] = b, d, c
    x = 0.5 * (points[a, 0] + points[b, 0])
    y = 0.5 * (points[a, 1] + points[b, 1])
    z = 0.5 * (points[a, 2] + points[b, 2])
    worst = worst_at(points, faces, 2 * count, x, y, z, measure, 0.0)
    if worst <= 0.0:
        return -1
    reach = 0.5 * _distance(points, a, b)
    x, y, z, worst = climb(points, faces, 2 * count, x, y, z, reach, measure, steps, worst)
    if worst <= floor:
        return -1
    node = state.counts[POINTS]
    state.counts[POINTS] += 1
    points[node, 0], points[node, 1], points[node, 2] = x, y, z
    state.size[node] = 0.5 * (state.size[a] + state.size[b])
    state.frozen[node] = False
    for i in range(2 * count):
        for k in range(3):
            work.new[i, k] = faces[i, k]
        work.new[i, 3] = node
        work.new_quality[i] = quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure)
    replace_cavity(state, work.ring_tets, count, 2 * count, work)
    return node
