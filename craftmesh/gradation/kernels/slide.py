"""Moves of vertices: inside their patch for larger angles, along junction lines for equal edge spacing.

The star is the set of facets around the moving vertex. The tip, their common corner, has the new position.
"""

import numpy as np

from craftmesh.gradation.kernels.cones import keep_volumes
from craftmesh.gradation.kernels.guards import attempt
from craftmesh.gradation.kernels.projection import put_on_crack_in_box, put_on_front, put_on_planes
from craftmesh.gradation.kernels.result_codes import DONE, LINK, NO_NEED, ON_CRACK, ON_FRONT, is_held
from craftmesh.gradation.kernels.rings import is_feature
from craftmesh.gradation.kernels.star import star_at, worst_score
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import angle_score, area_vector, keeps_normal, squared_distance

# Search for a larger angle inside a patch: number of steps, directions tried per step, and length of the
# first step in target lengths, which is halved when no direction helps.
STEPS = 7
DIRECTIONS = 8
FIRST_STEP = 0.3
# Search along a junction line: number of points towards each neighbour, and their spacing as a fraction of
# the edge.
LINE_PLACES = 7
LINE_STEP = 0.1
# Smallest rise of the smallest `angle_score` (1 at an angle of 15 or 135 degrees) around a vertex, by the
# move that the search finds, and by the possibly shorter move that passes the checks of `guards.attempt`.
LEAST_RISE = 1e-3
# Number of attempts at a move, each half as long as the one before.
SLIDE_TRIES = 3
# Largest move of a vertex to keep the volumes, in target lengths.
VOLUME_REACH = 0.2
# Smallest move for equal spacing, in target lengths; shorter moves are skipped.
EVEN = 0.05


@lean_kernel
def constrain(state, star):
    """Move the star's tip, the new position of its vertex, to where the vertex may be.

    A front vertex is put on the front and a crack vertex on the given crack. Other vertices are shifted so
    that the grains keep their volumes, by at most VOLUME_REACH target lengths. Last, all are put on their
    box planes.
    """
    v = star.vertex
    flags = state.flags[v]
    place = state.points[star.tip]
    if flags & ON_FRONT:
        put_on_front(state.front, place)
    elif flags & ON_CRACK:
        put_on_crack_in_box(state, flags, v, place)
    else:
        keep_volumes(state, star, flags, VOLUME_REACH * state.size[v])
    put_on_planes(state, flags, v, place)


@lean_kernel
def put_between(state, star, goal, share):
    """Set the star's tip, the vertex' new position, to the fraction `share` of the way to `goal` (3,)."""
    for k in range(3):
        start = state.points[star.vertex, k]
        state.points[star.tip, k] = start + share * (goal[k] - start)


@lean_kernel
def slide_towards(state, grid, limits, star, goal, floor, rise):
    """Move the star's vertex to `goal` (3,), or half or a quarter as far; return DONE or why not.

    Each position is first put on front, crack and box planes (`constrain`). floor, rise: every new facet
    must have the angle score `floor`, or the old facets' smallest score plus `rise` if that is less. More
    score is better; it is 1 at a smallest angle of 15 or a largest of 135 degrees.
    """
    share = 1.0
    reason = NO_NEED
    for _ in range(SLIDE_TRIES):
        put_between(state, star, goal, share)
        constrain(state, star)
        reason = attempt(state, grid, limits, star, floor, rise)
        if reason == DONE:
            break
        share *= 0.5
    return reason


@lean_kernel
def line_neighbours(state, v):
    """Return the two vertices joined to `v` by feature edges, or -1, -1 if there are not exactly two."""
    found = -1
    other = -1
    c = state.first[v]
    while c >= 0:
        for i in range(1, 3):
            u = state.facets[c // 3, (c + i) % 3]
            if state.rank[u] > 0 and u != found and u != other:
                if is_feature(state.facets, state.patch, state.first, state.after, v, u):
                    if found < 0:
                        found = u
                    elif other < 0:
                        other = u
                    else:
                        return -1, -1
        c = state.after[c]
    if other < 0:
        return -1, -1
    return found, other


@lean_kernel
def _score_at(state, star, place, cosine, least):
    """Return the smallest angle score of the facets with the star's tip, their common corner, at `place`.

    The result is -1 if the score is not over `least`, or if a facet's normal turns too far (`cosine`) from
    its reference normal.
    """
    points, reference, changed, corners = state.points, state.reference, state.star, state.star_corners
    for k in range(3):
        points[star.tip, k] = place[k]
    worst = np.inf
    for i in range(star.moved):
        p = corners[i, 0]
        q = corners[i, 1]
        r = corners[i, 2]
        worst = min(worst, angle_score(points, p, q, r))
        if worst <= least or not keeps_normal(points, reference, changed[i], p, q, r, cosine):
            return -1.0
    return worst


@kernel
def _tangents(state, star, first, second):
    """Set two perpendicular unit vectors, `first` and `second` (3,), tangent to the patch at the vertex.

    For a vertex on a box plane they lie in this plane. Return False if the facets have no area.
    """
    normal = np.zeros(3)
    for i in range(star.moved):
        p, q, r = state.star_corners[i]
        x, y, z = area_vector(state.points, p, q, r)
        normal[0] += x
        normal[1] += y
        normal[2] += z
    for k in range(3):
        if is_held(state.flags[star.vertex], k):
            normal[:] = 0.0
            normal[k] = 1.0
            break
    length = np.sqrt(np.dot(normal, normal))
    if length == 0.0:
        return False
    normal /= length
    first[:] = 0.0
    first[np.argmin(np.abs(normal))] = 1.0
    first -= np.dot(first, normal) * normal
    first /= np.sqrt(np.dot(first, first))
    second[:] = np.cross(normal, first)
    return True


@kernel
def _best_in_patch(state, star, cosine, score, place):
    """Move `place` (3,) along the patch to raise the smallest angle score; return the new score.

    score: the smallest one at the start. Positions where a normal turns too far (`cosine`) do not count.
    """
    first = np.empty(3)
    second = np.empty(3)
    if not _tangents(state, star, first, second):
        return score
    step = FIRST_STEP * state.size[star.vertex]
    start = np.empty(3)
    trial = np.empty(3)
    for _ in range(STEPS):
        found = False
        start[:] = place
        for n in range(DIRECTIONS):
            angle = 2.0 * np.pi * n / DIRECTIONS
            along = step * np.cos(angle)
            across = step * np.sin(angle)
            for k in range(3):
                trial[k] = start[k] + along * first[k] + across * second[k]
            new = _score_at(state, star, trial, cosine, score)
            if new > score:
                score = new
                place[:] = trial
                found = True
        if not found:
            step *= 0.5
    return score


@kernel
def _best_on_line(state, star, cosine, score, place):
    """Move `place` (3,) along the junction line to raise the smallest angle score; return the new score.

    score: the smallest one at the start. Positions where a normal turns too far (`cosine`) do not count.
    """
    p, q = line_neighbours(state, star.vertex)
    if p < 0:
        return score
    start = place.copy()
    trial = np.empty(3)
    for n in range(1, LINE_PLACES + 1):
        for end in (p, q):
            for k in range(3):
                trial[k] = start[k] + LINE_STEP * n * (state.points[end, k] - start[k])
            new = _score_at(state, star, trial, cosine, score)
            if new > score:
                score = new
                place[:] = trial
    return score


@kernel
def slide_vertex(state, grid, limits, v, goal):
    """Move `v` to raise the smallest angle score of its facets if it is under `goal`.

    The angle score of a facet is 1 at a smallest angle of 15 or a largest of 135 degrees, more if better.
    Return DONE or the reason why not. A front vertex moves only if the score is under limits.floor too,
    because the computation of stress intensity factors needs an equally spaced front.
    """
    star = star_at(state, v)
    if star.moved <= 0:
        return LINK
    if state.flags[v] & ON_FRONT:
        goal = min(goal, limits.floor)
    old = worst_score(state, star)
    if old >= goal:
        return NO_NEED
    best = state.points[v].copy()
    if state.rank[v] == 0:
        score = _best_in_patch(state, star, limits.cosine, old, best)
    else:
        score = _best_on_line(state, star, limits.cosine, old, best)
    if score <= old + LEAST_RISE:
        return NO_NEED
    return slide_towards(state, grid, limits, star, best, old + LEAST_RISE, np.inf)


@lean_kernel
def _even_place(state, v, p, q, place):
    """Set `place` on the line p - v - q where both edges have equal ratios to their target lengths.

    Return whether it is at least EVEN target lengths away from v.
    """
    to_p = np.sqrt(squared_distance(state.points, v, p))
    to_q = np.sqrt(squared_distance(state.points, v, q))
    share = (state.size[v] + state.size[p]) / (2.0 * state.size[v] + state.size[p] + state.size[q])
    ahead = share * (to_p + to_q) - to_p
    end = q if ahead > 0.0 else p
    length = to_q if ahead > 0.0 else to_p
    part = 0.0 if length == 0.0 else abs(ahead) / length
    for k in range(3):
        place[k] = state.points[v, k] + part * (state.points[end, k] - state.points[v, k])
    return abs(ahead) > EVEN * state.size[v]


@kernel
def even_vertex(state, grid, limits, v):
    """Move the line vertex `v` until its two line edges have equal ratios to their target lengths.

    Return DONE or the reason why not; the move is not tried a second time with a shorter way.
    """
    p, q = line_neighbours(state, v)
    place = np.empty(3)
    if p < 0 or not _even_place(state, v, p, q, place):
        return NO_NEED
    star = star_at(state, v)
    if star.moved < 0:
        return LINK
    state.points[star.tip] = place
    constrain(state, star)
    return attempt(state, grid, limits, star, limits.floor, 0.0)
