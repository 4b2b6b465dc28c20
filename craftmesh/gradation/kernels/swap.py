"""Edge swap inside patches: the other diagonal of two facets where it raises the smallest angle."""

import numpy as np
from numba import njit

from craftmesh.gradation.kernels.codes import ON_FRONT
from craftmesh.gradation.kernels.cones import add_cone, book_drift, drift_allows
from craftmesh.gradation.kernels.facet_grid import has_room, insert_facet
from craftmesh.gradation.kernels.rings import edge_facets, link_corner, third_corner, unlink_corner
from craftmesh.gradation.kernels.star import hits
from craftmesh.gradation.kernels.witnesses import TOO_MANY, collect, find_new_homes, settle
from craftmesh.surface.kernels.facet_shape import cosine_range, facet_distance2, keeps_normal

LEAST_GAIN = 1e-3
# Edges that wait for another look while swaps spread from one edge.
MOST_WAITING = 256


@njit(cache=True)
def _runs_along(state, f, a, b):
    """Tell whether facet `f` goes from corner `a` to corner `b`."""
    for k in range(3):
        if state.facets[f, k] == a:
            return state.facets[f, (k + 1) % 3] == b
    return False


@njit(cache=True)
def _set_star(state, f, g, u, v, p, q):
    """Put the facets (u, p, v) and (u, v, q) that replace f = (u, p, q) and g = (v, q, p) into the star."""
    state.star[0] = f
    state.star[1] = g
    state.star_corners[0, 0] = u
    state.star_corners[0, 1] = p
    state.star_corners[0, 2] = v
    state.star_corners[1, 0] = u
    state.star_corners[1, 1] = v
    state.star_corners[1, 2] = q


@njit(cache=True)
def _raises_angle(state, u, v, p, q):
    points = state.points
    old = max(cosine_range(points, u, p, q)[0], cosine_range(points, v, q, p)[0])
    new = max(cosine_range(points, u, p, v)[0], cosine_range(points, u, v, q)[0])
    return new < old - LEAST_GAIN


@njit(cache=True)
def _keeps_normals(state, cosine):
    for i in range(2):
        p = state.star_corners[i, 0]
        q = state.star_corners[i, 1]
        r = state.star_corners[i, 2]
        if not keeps_normal(state.points, state.reference, state.star[i], p, q, r, cosine):
            return False
    return True


@njit(cache=True)
def _stays_near(state, limits, u, v, p, q):
    """Tell whether the new edge's middle and the old one's are close to the facets of the other state."""
    tolerance = limits.distance * 0.25 * (state.size[u] + state.size[v] + state.size[p] + state.size[q])
    if state.patch_crack[state.patch[state.star[0]]]:
        tolerance = min(tolerance, limits.crack_distance)
    middle = np.empty((2, 3))
    for k in range(3):
        middle[0, k] = 0.5 * (state.points[u, k] + state.points[v, k])
        middle[1, k] = 0.5 * (state.points[p, k] + state.points[q, k])
    points = state.points
    d = facet_distance2(points, v, q, p, middle, 0, facet_distance2(points, u, p, q, middle, 0, np.inf))
    e = facet_distance2(points, u, v, q, middle, 1, facet_distance2(points, u, p, v, middle, 1, np.inf))
    return max(d, e) <= tolerance * tolerance


@njit(cache=True)
def _replace_corner(state, f, old, new):
    for k in range(3):
        if state.facets[f, k] == old:
            unlink_corner(state.first, state.after, old, 3 * f + k)
            state.facets[f, k] = new
            link_corner(state.first, state.after, new, 3 * f + k)


@njit(cache=True)
def swap_edge(state, grid, limits, a, b):
    """Swap edge (a, b) when it lies inside a patch, gains angle and every guard holds."""
    count, f, g = edge_facets(state.facets, state.first, state.after, a, b)
    if count != 2 or state.patch[f] != state.patch[g]:
        return False
    i = 0
    while state.facets[f, i] == a or state.facets[f, i] == b:
        i += 1
    u = state.facets[f, i]
    p = state.facets[f, (i + 1) % 3]
    q = state.facets[f, (i + 2) % 3]
    v = third_corner(state.facets, g, a, b)
    if u == v or not _runs_along(state, g, q, p) or not _raises_angle(state, u, v, p, q):
        return False
    if edge_facets(state.facets, state.first, state.after, u, v)[0] > 0:
        return False
    if state.patch_crack[state.patch[f]] and state.flags[u] & state.flags[v] & ON_FRONT:
        return False  # an ear
    _set_star(state, f, g, u, v, p, q)
    if not _keeps_normals(state, limits.cosine) or not _stays_near(state, limits, u, v, p, q):
        return False
    rows = add_cone(state, g, state.points[u], np.int64(0))
    if not drift_allows(state, rows, limits.drift):
        return False
    loose = collect(state, g, collect(state, f, np.int64(0)))
    size = 0.25 * (state.size[u] + state.size[v] + state.size[p] + state.size[q])
    if loose == TOO_MANY:
        return False
    if not find_new_homes(state, loose, np.int64(2), limits.distance, size, limits.crack_distance):
        return False
    if hits(state, grid, np.int64(2), np.int64(0)):
        return False
    book_drift(state, rows)
    state.witness_first[f] = -1
    state.witness_first[g] = -1
    _replace_corner(state, f, q, v)
    _replace_corner(state, g, p, u)
    settle(state, loose)
    for n in range(2):
        t = state.star[n]
        insert_facet(grid, state.points, t, state.facets[t, 0], state.facets[t, 1], state.facets[t, 2])
    return True


@njit(cache=True)
def swap_pass(state, grid, limits, edges, start):
    """Swap what gains among `edges` from `start` on, and then among the edges round each swap.

    Returns where it stopped and how many it swapped.
    """
    done = 0
    waiting = np.empty((MOST_WAITING, 2), np.int64)
    for n in range(start, len(edges)):
        waiting[0] = edges[n]
        count = 1
        while count > 0:
            if not has_room(grid):
                return n, done
            count -= 1
            a = waiting[count, 0]
            b = waiting[count, 1]
            if state.first[a] < 0 or not swap_edge(state, grid, limits, a, b):
                continue
            done += 1
            if count + 4 <= MOST_WAITING:
                u, p, v = state.star_corners[0]
                q = state.star_corners[1, 2]
                for first, second in ((u, p), (p, v), (v, q), (q, u)):
                    waiting[count, 0] = first
                    waiting[count, 1] = second
                    count += 1
    return len(edges), done
