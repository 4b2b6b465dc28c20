"""Moving vertices: inside their patch for better angles, along their junction line for even edges."""

import numpy as np
from numba import njit

from craftmesh.gradation.kernels.codes import (
    DISTANCE,
    DONE,
    INTERSECTION,
    LINK,
    ON_CRACK,
    ON_FRONT,
    VOLUME,
    is_held,
)
from craftmesh.gradation.kernels.cones import book_drift, drift_allows, grain_cones, volume_shift
from craftmesh.gradation.kernels.facet_grid import has_room
from craftmesh.gradation.kernels.projection import put_on_crack_in_box, put_on_front
from craftmesh.gradation.kernels.rings import is_feature
from craftmesh.gradation.kernels.star import enter_star, hits, shape_refusal, star_of, worst_score
from craftmesh.gradation.kernels.witnesses import TOO_MANY, collect, find_new_homes, set_free, settle
from craftmesh.surface.kernels.facet_shape import angle_score, area_vector, keeps_normal, squared_distance

STEPS = 7
DIRECTIONS = 8


@njit(cache=True)
def _collect_loose(state, moved, v):
    count = 0
    for i in range(moved):
        count = collect(state, state.star[i], count)
    return set_free(state, v, state.star[0], count)


@njit(cache=True)
def relocate(state, grid, limits, v, place, floor):
    """Move vertex `v` to `place` when every guard holds and all angle scores reach `floor`."""
    moved = star_of(state, v)
    if moved < 0:
        return LINK
    rows = grain_cones(state, moved, np.int64(0), place)
    if not drift_allows(state, rows, limits.drift):
        return VOLUME
    before = state.points[v].copy()
    state.points[v] = place
    reason = shape_refusal(state, moved, v, floor, limits.cosine, limits.longest)
    loose = 0
    if reason == DONE:
        loose = _collect_loose(state, moved, v)
        if loose == TOO_MANY or not find_new_homes(
            state, loose, moved, limits.distance, state.size[v], limits.crack_distance
        ):
            reason = DISTANCE
    if reason == DONE and hits(state, grid, moved, np.int64(0)):
        reason = INTERSECTION
    if reason != DONE:
        state.points[v] = before
        return reason
    book_drift(state, rows)
    for i in range(moved):
        state.witness_first[state.star[i]] = -1
    settle(state, loose)
    enter_star(state, grid, moved)
    return DONE


@njit(cache=True)
def constrain(state, v, place):
    """Put `place` back onto what holds vertex `v`: front, crack, box planes; else keep the volumes."""
    flags = state.flags[v]
    if flags & ON_FRONT:
        put_on_front(state.front, place)
    elif flags & ON_CRACK:
        put_on_crack_in_box(state, flags, v, place)
    else:
        moved = star_of(state, v)
        shift = np.empty(3)
        volume_shift(state, grain_cones(state, moved, np.int64(0), place), flags, shift)
        reach = 0.2 * state.size[v]
        length = np.sqrt(shift[0] ** 2 + shift[1] ** 2 + shift[2] ** 2)
        if length > reach:
            shift *= reach / length
        place += shift
    for k in range(3):
        if is_held(flags, k):
            place[k] = state.points[v, k]


@njit(cache=True)
def line_neighbours(state, v):
    """Return the two vertices joined to the line vertex `v` by feature edges, or -1, -1."""
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


@njit(cache=True)
def _score_at(state, moved, v, place, cosine, least):
    """Return the star's least angle score with `v` at `place`; -1 when under `least` or turned too far."""
    points, reference, star, corners = state.points, state.reference, state.star, state.star_corners
    x, y, z = points[v]
    points[v] = place
    worst = np.inf
    for i in range(moved):
        p = corners[i, 0]
        q = corners[i, 1]
        r = corners[i, 2]
        worst = min(worst, angle_score(points, p, q, r))
        if worst <= least or not keeps_normal(points, reference, star[i], p, q, r, cosine):
            worst = -1.0
            break
    points[v, 0] = x
    points[v, 1] = y
    points[v, 2] = z
    return worst


@njit(cache=True)
def _tangents(state, moved, v, first, second):
    """Set two unit directions along the patch at `v`, inside the box planes that hold it."""
    normal = np.zeros(3)
    for i in range(moved):
        p, q, r = state.star_corners[i]
        x, y, z = area_vector(state.points, p, q, r)
        normal[0] += x
        normal[1] += y
        normal[2] += z
    for k in range(3):
        if is_held(state.flags[v], k):
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


@njit(cache=True)
def _best_in_patch(state, moved, v, cosine, score, place):
    """Climb from `place` along the patch to a better least angle score; return the score."""
    first = np.empty(3)
    second = np.empty(3)
    if not _tangents(state, moved, v, first, second):
        return score
    step = 0.3 * state.size[v]
    for _ in range(STEPS):
        found = False
        start = place.copy()
        for n in range(DIRECTIONS):
            angle = 2.0 * np.pi * n / DIRECTIONS
            trial = start + step * (np.cos(angle) * first + np.sin(angle) * second)
            new = _score_at(state, moved, v, trial, cosine, score)
            if new > score:
                score = new
                place[:] = trial
                found = True
        if not found:
            step *= 0.5
    return score


@njit(cache=True)
def _best_on_line(state, moved, v, cosine, score, place):
    """Climb along the junction line at `v` to a better least angle score; return the score."""
    p, q = line_neighbours(state, v)
    if p < 0:
        return score
    start = place.copy()
    for n in range(1, 8):
        for end in (p, q):
            trial = start + 0.1 * n * (state.points[end] - start)
            new = _score_at(state, moved, v, trial, cosine, score)
            if new > score:
                score = new
                place[:] = trial
    return score


@njit(cache=True)
def slide_vertex(state, grid, limits, v, goal):
    """Move `v` for a better least angle when that is under the score `goal`; tell whether it moved."""
    moved = star_of(state, v)
    if moved <= 0:
        return False
    old = worst_score(state, moved, np.int64(0))
    if old >= goal:
        return False
    best = state.points[v].copy()
    if state.rank[v] == 0:
        score = _best_in_patch(state, moved, v, limits.cosine, old, best)
    else:
        score = _best_on_line(state, moved, v, limits.cosine, old, best)
    if score <= old + 1e-3:
        return False
    start = state.points[v].copy()
    for share in (1.0, 0.5, 0.25):
        place = start + share * (best - start)
        constrain(state, v, place)
        if relocate(state, grid, limits, v, place, old + 1e-3) == DONE:
            return True
    return False


@njit(cache=True)
def slide_pass(state, grid, limits, order, start, goal):
    """Slide the vertices in `order` from `start` on; return where it stopped and how many moved."""
    done = 0
    for n in range(start, len(order)):
        if not has_room(grid):
            return n, done
        v = order[n]
        if state.first[v] >= 0 and state.rank[v] < 2 and slide_vertex(state, grid, limits, v, goal):
            done += 1
    return len(order), done


@njit(cache=True)
def _even_place(state, v, p, q, place):
    """Set `place` on the line p - v - q where both edges have the same length over target."""
    to_p = np.sqrt(squared_distance(state.points, v, p))
    to_q = np.sqrt(squared_distance(state.points, v, q))
    share = (state.size[v] + state.size[p]) / (2.0 * state.size[v] + state.size[p] + state.size[q])
    ahead = share * (to_p + to_q) - to_p
    end = q if ahead > 0.0 else p
    length = to_q if ahead > 0.0 else to_p
    part = 0.0 if length == 0.0 else abs(ahead) / length
    for k in range(3):
        place[k] = state.points[v, k] + part * (state.points[end, k] - state.points[v, k])
    return abs(ahead) > 0.05 * state.size[v]


@njit(cache=True)
def even_lines_pass(state, grid, limits, order, start):
    """Move line vertices to where their two line edges are equally long over their targets."""
    done = 0
    place = np.empty(3)
    for n in range(start, len(order)):
        if not has_room(grid):
            return n, done
        v = order[n]
        if state.first[v] < 0 or state.rank[v] != 1:
            continue
        p, q = line_neighbours(state, v)
        if p < 0 or not _even_place(state, v, p, q, place):
            continue
        constrain(state, v, place)
        moved = star_of(state, v)
        floor = min(limits.floor, worst_score(state, moved, np.int64(0)))
        if relocate(state, grid, limits, v, place, floor) == DONE:
            done += 1
    return len(order), done


@njit(cache=True)
def move_pass(state, grid, limits, vertices, places, start):
    """Move each of `vertices` to its place (k, 3), or a part of the way, where the guards allow it."""
    done = 0
    for n in range(start, len(vertices)):
        if not has_room(grid):
            return n, done
        v = vertices[n]
        origin = state.points[v].copy()
        floor = min(limits.floor, worst_score(state, star_of(state, v), np.int64(0)))
        for share in (1.0, 0.6, 0.3):
            place = origin + share * (places[n] - origin)
            if relocate(state, grid, limits, v, place, floor) == DONE:
                done += 1
                break
    return len(vertices), done
