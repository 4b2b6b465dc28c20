"""Changes of topology: removal of an edge or face, contraction or insertion of a point, if the value rises.

The value is what the aim's objective measures (`tet_objective`). Old and new tets have the same outer
faces, and all new tets have positive volumes. No surface or crack facet lies inside the old tets. A ring is
the cycle of tets, or of their nodes, around an edge.
"""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import (
    EDGES,
    FACES,
    POINTS,
    find_ring,
    find_star,
    has_room,
    node_across,
    replace_cavity,
)
from craftmesh.tetrahedra.kernels.tet_cone import ANYWHERE, FIRST_STEP, Cone, goal_at, walk
from craftmesh.tetrahedra.kernels.tet_objective import (
    FAULTS,
    INSERTION_GAIN,
    NO_TET,
    RATIOS,
    WORST,
    joined,
    limit_for,
    of_none,
    sound_worth,
    value_of,
    value_of_new,
)
from craftmesh.tetrahedra.kernels.tet_quality import INVERTED, quality_at, quality_of

# Largest number of tets around an edge that is removed for a lower mean aspect ratio: larger rings took
# nine tenths of the time for 198 of 8,071 removals.
RATIOS_RING = 4
# Longest edge that a contraction may make, in target lengths; chosen by hand.
LONGEST = 1.6


@lean_kernel
def _best_triangulation(points, ends, count, aim, limit, work):
    """Fill the tables of Klincsek's algorithm and return the best value of tets that fill the whole ring.

    The algorithm finds the best triangulation of the ring's nodes by dynamic programming; each triangle
    makes one tet with each end of the edge, `ends`. work.best[i, k]: best value of tets on the nodes i to
    k, -INVERTED if no tets with qualities over the limit fill them; work.split[i, k]: third node of the
    triangle on i and k.
    """
    a, b = ends
    ring, best, split = work.ring, work.best, work.split
    for i in range(count - 2, -1, -1):
        best[i, i + 1] = of_none(aim.objective)
        for k in range(i + 2, count):
            most, apex = -INVERTED, -1
            for j in range(i + 1, k):
                least = most if aim.objective == WORST else -INVERTED
                value = joined(best[i, j], best[j, k], aim.objective)
                if value <= least:
                    continue
                worth = sound_worth(points, (a, ring[i], ring[j], ring[k]), aim, limit)
                value = joined(value, worth, aim.objective)
                if value <= least:
                    continue
                worth = sound_worth(points, (ring[i], ring[j], ring[k], b), aim, limit)
                value = joined(value, worth, aim.objective)
                if value > most:
                    most, apex = value, j
            best[i, k] = most
            split[i, k] = apex
    return best[0, count - 1]


@lean_kernel
def _list_triangulation(points, ends, count, measure, work):
    """Write the tets of the triangulation in work.split, and their qualities, to work.new and new_quality.

    Return the number of tets. ends: the nodes of the edge that is removed.
    """
    a, b = ends
    ring, split, stack, new, new_quality = work.ring, work.split, work.stack, work.new, work.new_quality
    stack[0, 0], stack[0, 1] = 0, count - 1
    height, made = 1, 0
    while height > 0:
        height -= 1
        i, k = stack[height, 0], stack[height, 1]
        if k - i < 2:
            continue
        j = split[i, k]
        new[made, 0], new[made, 1], new[made, 2], new[made, 3] = a, ring[i], ring[j], ring[k]
        new_quality[made] = quality_of(points, a, ring[i], ring[j], ring[k], measure)
        made += 1
        new[made, 0], new[made, 1], new[made, 2], new[made, 3] = ring[i], ring[j], ring[k], b
        new_quality[made] = quality_of(points, ring[i], ring[j], ring[k], b, measure)
        made += 1
        stack[height, 0], stack[height, 1] = i, j
        stack[height + 1, 0], stack[height + 1, 1] = j, k
        height += 2
    return made


@lean_kernel
def remove_edge(state, t, edge, aim, work):
    """Remove an edge of tet t by the best triangulation of its ring, if the tets' value rises by aim.gain.

    The ring is the cycle of nodes around the edge. Return whether the edge was removed. Edges on surface
    and crack, and edges in more than MAX_RING tets (for the objective RATIOS, RATIOS_RING), stay.
    """
    count = find_ring(state, t, edge, work.ring, work.ring_tets)
    if count < 3 or (aim.objective == RATIOS and count > RATIOS_RING) or not has_room(state):
        return False
    ends = (state.tets[t, EDGES[edge, 0]], state.tets[t, EDGES[edge, 1]])
    limit = limit_for(state, work.ring_tets, count, aim)
    value = _best_triangulation(state.points, ends, count, aim, limit, work)
    if value <= -INVERTED or value < value_of(state, work.ring_tets, count, aim) + aim.gain:
        return False
    made = _list_triangulation(state.points, ends, count, aim.measure, work)
    replace_cavity(state, work.ring_tets, count, made, work)
    return True


@lean_kernel
def remove_face(state, t, k, aim, work):
    """Replace the two tets at the face opposite corner k of tet t by three around a new edge.

    Return whether this was done. The value of these tets must rise by the aim's gain, and the face must not
    be a surface or crack facet.
    """
    tets, new = state.tets, work.new
    r = node_across(state, t, k)
    if r < 0 or not has_room(state):
        return False
    work.ring_tets[0], work.ring_tets[1] = t, state.neighbours[t, k]
    limit = limit_for(state, work.ring_tets, 2, aim)
    p = tets[t, k]
    for i in range(3):
        x, y = tets[t, FACES[k, i]], tets[t, FACES[k, (i + 1) % 3]]
        new[i, 0], new[i, 1], new[i, 2], new[i, 3] = r, p, x, y
        work.new_quality[i] = quality_of(state.points, r, p, x, y, aim.measure)
        if work.new_quality[i] <= limit:
            return False
    if value_of_new(state, 3, aim, work) < value_of(state, work.ring_tets, 2, aim) + aim.gain:
        return False
    replace_cavity(state, work.ring_tets, 2, 3, work)
    return True


@lean_kernel
def _distance(points, a, b):
    return np.sqrt(
        (points[a, 0] - points[b, 0]) ** 2
        + (points[a, 1] - points[b, 1]) ** 2
        + (points[a, 2] - points[b, 2]) ** 2
    )


@lean_kernel
def _list_contraction(state, v, w, count, measure, limit, work):
    """Write to work.new the tets that remain when v merges into w; return their number.

    They join the outer faces of v's tets, work.star[:count], to w. The number is -1 if a new quality does
    not exceed the limit, or a new edge is longer than LONGEST target lengths.
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
        work.new_quality[made] = quality_of(points, new[0], new[1], new[2], new[3], measure)
        if work.new_quality[made] <= limit:
            return -1
        made += 1
    return made


@lean_kernel
def _list_neighbours(state, v, count, work):
    """Write the points joined to v by tets work.star[:count] to work.keys[:, 0]; return their number."""
    found = 0
    for i in range(count):
        for k in range(4):
            w = state.tets[work.star[i], k]
            known = w == v
            for j in range(found):
                known = known or work.keys[j, 0] == w
            if not known:
                work.keys[found, 0] = w
                found += 1
    return found


@lean_kernel
def contract(state, v, aim, work):
    """Merge the interior point v into its best neighbour, if the tets' value rises by more than aim.gain.

    Return whether it was merged; surface points never are.
    """
    if v < len(state.reach) - 1:
        return False
    count = find_star(state, v, work.star)
    if count < 0 or not has_room(state):
        return False
    limit = limit_for(state, work.star, count, aim)
    most, best = value_of(state, work.star, count, aim) + aim.gain, -1
    for j in range(_list_neighbours(state, v, count, work)):
        made = _list_contraction(state, v, work.keys[j, 0], count, aim.measure, limit, work)
        if made < 0:
            continue
        value = value_of_new(state, made, aim, work)
        if value > most:
            most, best = value, work.keys[j, 0]
    if best < 0:
        return False
    made = _list_contraction(state, v, best, count, aim.measure, limit, work)
    state.tet_of[v] = -1
    replace_cavity(state, work.star, count, made, work)
    return True


@lean_kernel
def _ring_faces(state, t, edge, count, work):
    """Write to work.faces the outer faces of the tets around an edge of tet t; return their number.

    work.ring[:count] has the nodes around the edge.
    """
    faces, a, b = work.faces, state.tets[t, EDGES[edge, 0]], state.tets[t, EDGES[edge, 1]]
    for i in range(count):
        c, d = work.ring[i], work.ring[(i + 1) % count]
        faces[2 * i, 0], faces[2 * i, 1], faces[2 * i, 2] = a, c, d
        faces[2 * i + 1, 0], faces[2 * i + 1, 1], faces[2 * i + 1, 2] = b, d, c
    return 2 * count


@lean_kernel
def _add_apex(state, cone, place, size, work):
    """Add a point with the target length `size` at `place` and write the cone's tets; return its id."""
    node = state.counts[POINTS]
    state.counts[POINTS] += 1
    x, y, z = place
    state.points[node, 0], state.points[node, 1], state.points[node, 2] = x, y, z
    state.size[node] = size
    state.frozen[node] = False
    faces = cone.faces
    for i in range(cone.count):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        work.new[i, 0], work.new[i, 1], work.new[i, 2], work.new[i, 3] = a, b, c, node
        work.new_quality[i] = quality_at(state.points, a, b, c, x, y, z, cone.measure)
    return node


@lean_kernel
def insert_on_edge(state, t, edge, aim, work):
    """Replace the tets around an edge of tet t by tets at a new point, if the value rises enough.

    Return the point's id, or -1 if none was inserted. Its position is found by a search from the edge's
    midpoint. The tets' value must rise by the objective's INSERTION_GAIN, not by the aim's gain.
    """
    count = find_ring(state, t, edge, work.ring, work.ring_tets)
    if count < 3 or not has_room(state):
        return -1
    points, a, b = state.points, state.tets[t, EDGES[edge, 0]], state.tets[t, EDGES[edge, 1]]
    cone = Cone(points, work.faces, _ring_faces(state, t, edge, count, work), aim.measure)
    x, y = 0.5 * (points[a, 0] + points[b, 0]), 0.5 * (points[a, 1] + points[b, 1])
    z, half = 0.5 * (points[a, 2] + points[b, 2]), 0.5 * _distance(points, a, b)
    least = value_of(state, work.ring_tets, count, aim) + INSERTION_GAIN[aim.objective]
    lighter = aim.objective == FAULTS
    lowest, enough = (-NO_TET, 0.0) if lighter else (0.0, max(least, aim.floor))
    value = goal_at(cone, x, y, z, lowest, lighter)
    if value <= lowest or least > enough:
        return -1
    step, disc = FIRST_STEP * half, ((x, y, z), np.inf)
    place, value = walk(cone, (x, y, z), step, disc, ANYWHERE, (value, enough), lighter)
    if value < least:
        return -1
    node = _add_apex(state, cone, place, 0.5 * (state.size[a] + state.size[b]), work)
    replace_cavity(state, work.ring_tets, count, 2 * count, work)
    return node
