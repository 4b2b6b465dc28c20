"""Edge swap inside patches: two facets get their other diagonal if this raises the smallest angle."""

from collections import namedtuple

import numpy as np

from craftmesh.gradation.kernels.collapse_rules import is_along_crack
from craftmesh.gradation.kernels.facet_grid import has_room
from craftmesh.gradation.kernels.guards import attempt
from craftmesh.gradation.kernels.result_codes import (
    CHORD,
    DISTANCE,
    DONE,
    EAR,
    LINK,
    NO_NEED,
    ON_CRACK,
    ON_FRONT,
    counted,
)
from craftmesh.gradation.kernels.rings import edge_facets, third_corner
from craftmesh.gradation.kernels.star import Star
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import cosine_range, facet_distance2

# Smallest decrease, by a swap, of the cosine of the smallest angle. It prevents that swaps undo each other
# without end.
LEAST_GAIN = 1e-3
# Most queued edges while swaps spread from one edge; further edges wait for the next pass.
MOST_WAITING = 256
# Facets f = (u, p, q) and g = (v, q, p) on the edge (p, q), which (u, v) replaces: (u, p, v) and (u, v, q).
Quad = namedtuple("Quad", "f g u p v q")


@lean_kernel
def _runs_along(state, f, a, b):
    """Return whether facet `f` has corner `b` directly after corner `a`."""
    for k in range(3):
        if state.facets[f, k] == a:
            return state.facets[f, (k + 1) % 3] == b
    return False


@lean_kernel
def quad_at(state, a, b):
    """Return the Quad of edge (a, b), the two facets on the edge with their corners.

    The quad's u is -1 unless the edge has exactly two facets, of one patch and equally oriented.
    """
    count, f, g = edge_facets(state.facets, state.first, state.after, a, b)
    if count != 2 or state.patch[f] != state.patch[g]:
        return Quad(f, g, np.int64(-1), a, np.int64(-1), b)
    i = 0
    while state.facets[f, i] == a or state.facets[f, i] == b:
        i += 1
    u = state.facets[f, i]
    p = state.facets[f, (i + 1) % 3]
    q = state.facets[f, (i + 2) % 3]
    v = third_corner(state.facets, g, a, b)
    if u == v or not _runs_along(state, g, q, p):
        u = np.int64(-1)
    return Quad(f, g, u, p, v, q)


@lean_kernel
def _raises_angle(state, quad):
    points, u, p, v, q = state.points, quad.u, quad.p, quad.v, quad.q
    old = max(cosine_range(points, u, p, q)[0], cosine_range(points, v, q, p)[0])
    new = max(cosine_range(points, u, p, v)[0], cosine_range(points, u, v, q)[0])
    return new < old - LEAST_GAIN


@lean_kernel
def _star_of_swap(state, quad):
    """Fill state.star with the quad's two facets after the swap, and return this star.

    The star's vertex and tip, the corner that both new facets share, are the quad's u.
    """
    u, p, v, q = quad.u, quad.p, quad.v, quad.q
    state.star[0] = quad.f
    state.star[1] = quad.g
    state.star_corners[0, 0] = u
    state.star_corners[0, 1] = p
    state.star_corners[0, 2] = v
    state.star_corners[1, 0] = u
    state.star_corners[1, 1] = v
    state.star_corners[1, 2] = q
    size = 0.25 * (state.size[u] + state.size[v] + state.size[p] + state.size[q])
    return Star(u, u, np.int64(-1), np.int64(2), np.int64(0), size)


@kernel
def _stays_near(state, limits, quad, size):
    """Return whether the new edge's midpoint is near the old facets, and the old edge's near the new ones.

    Near is within limits.distance times `size`, the target length; on the crack also within crack_distance.
    """
    u, p, v, q = quad.u, quad.p, quad.v, quad.q
    tolerance = limits.distance * size
    if state.patch_crack[state.patch[quad.f]]:
        tolerance = min(tolerance, limits.crack_distance)
    middle = np.empty((2, 3))
    for k in range(3):
        middle[0, k] = 0.5 * (state.points[u, k] + state.points[v, k])
        middle[1, k] = 0.5 * (state.points[p, k] + state.points[q, k])
    points = state.points
    d = facet_distance2(points, v, q, p, middle, 0, facet_distance2(points, u, p, q, middle, 0, np.inf))
    e = facet_distance2(points, u, v, q, middle, 1, facet_distance2(points, u, p, v, middle, 1, np.inf))
    return max(d, e) <= tolerance * tolerance


@lean_kernel
def swap(state, grid, limits, quad):
    """Swap a quad's edge if that raises the smallest angle and passes all guards.

    Return DONE, the reason of refusal, or NO_NEED, also for an edge that is not inside a patch.
    """
    if quad.u < 0 or not _raises_angle(state, quad):
        return NO_NEED
    if edge_facets(state.facets, state.first, state.after, quad.u, quad.v)[0] > 0:
        return LINK
    both = state.flags[quad.u] & state.flags[quad.v]
    if state.patch_crack[state.patch[quad.f]]:
        if both & ON_FRONT:
            return EAR
    elif both & ON_CRACK and is_along_crack(state, quad.u, quad.v):
        return CHORD
    star = _star_of_swap(state, quad)
    if not _stays_near(state, limits, quad, star.size):
        return DISTANCE
    return attempt(state, grid, limits, star, -np.inf, 0.0)


@lean_kernel
def swap_round(state, grid, limits, a, b, waiting):
    """Swap edge (a, b) if that raises the smallest angle, then edges around each swap.

    Return the number of swaps. waiting: work array (k, 2) for edges to be tried; edges beyond its length
    wait for the next pass. The swaps end if the grid has no room for another one.
    """
    done = 0
    waiting[0, 0] = a
    waiting[0, 1] = b
    count = 1
    while count > 0 and has_room(grid):
        count -= 1
        if state.first[waiting[count, 0]] < 0:
            continue
        quad = quad_at(state, waiting[count, 0], waiting[count, 1])
        answer = swap(state, grid, limits, quad)
        done += counted(state.refused, answer)
        if answer == DONE and count + 4 <= len(waiting):
            u, p, v, q = quad.u, quad.p, quad.v, quad.q
            for first, second in ((u, p), (p, v), (v, q), (q, u)):
                waiting[count, 0] = first
                waiting[count, 1] = second
                count += 1
    return done
