"""Projection of new or moved vertices onto the crack, its front and box planes."""

import numpy as np

from craftmesh.gradation.kernels.result_codes import is_held
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.bins import Grid, cells_of_box
from craftmesh.surface.kernels.facet_shape import facet_distance2

# Most iterations of projection onto a curved crack and back onto the box plane. They converge to the trace,
# the line where the crack meets the box plane.
PROJECTION_ITERATIONS = 12
# Largest distance, in target lengths, of a vertex that is projected onto the given crack. Vertices that the
# insertion has moved farther off it, for example into a grain boundary, are not projected.
PROJECTION_DISTANCE = 0.25


@kernel
def _onto_segment(p, q, place, found):
    length2 = 0.0
    along = 0.0
    for k in range(3):
        length2 += (q[k] - p[k]) ** 2
        along += (place[k] - p[k]) * (q[k] - p[k])
    t = min(1.0, max(0.0, along / length2)) if length2 > 0.0 else 0.0
    for k in range(3):
        found[k] = p[k] + t * (q[k] - p[k])
    return (found[0] - place[0]) ** 2 + (found[1] - place[1]) ** 2 + (found[2] - place[2]) ** 2


@kernel
def _onto_facet(corners, place, found):
    e = corners[1] - corners[0]
    g = corners[2] - corners[0]
    w = place - corners[0]
    ee = np.dot(e, e)
    eg = np.dot(e, g)
    gg = np.dot(g, g)
    we = np.dot(w, e)
    wg = np.dot(w, g)
    area = ee * gg - eg * eg
    if area > 0.0:
        u = (gg * we - eg * wg) / area
        v = (ee * wg - eg * we) / area
        if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
            for k in range(3):
                found[k] = corners[0, k] + u * e[k] + v * g[k]
            return (found[0] - place[0]) ** 2 + (found[1] - place[1]) ** 2 + (found[2] - place[2]) ** 2
    best = np.inf
    trial = np.empty(3)
    for i in range(3):
        d = _onto_segment(corners[i], corners[(i + 1) % 3], place, trial)
        if d < best:
            best = d
            found[:] = trial
    return best


@kernel
def put_on_front(front, place):
    """Move `place` (3,) to the nearest point of the segments `front` (s, 2, 3)."""
    best = np.inf
    start = place.copy()
    trial = np.empty(3)
    for i in range(len(front)):
        d = _onto_segment(front[i, 0], front[i, 1], start, trial)
        if d < best:
            best = d
            place[:] = trial


@lean_kernel
def put_on_crack_in_box(state, planes, v, place):
    """Move `place` (3,) onto the given crack and onto the box planes of vertex `v` (bits of `planes`).

    The steps, crack and planes in turn, end after at most PROJECTION_ITERATIONS; then `place` is exactly on
    the planes, and near the crack.
    """
    for _ in range(PROJECTION_ITERATIONS):
        put_on_crack(state, PROJECTION_DISTANCE * state.size[v], place)
        if put_on_planes(state, planes, v, place) == 0.0:
            return


@lean_kernel
def put_on_planes(state, planes, v, place):
    """Set the coordinates of `place` (3,) that `planes` fix at vertex `v`; return the largest change."""
    off = 0.0
    for k in range(3):
        if is_held(planes, k):
            off = max(off, abs(place[k] - state.points[v, k]))
            place[k] = state.points[v, k]
    return off


@kernel
def put_on_crack(state, reach, place):
    """Move `place` (3,) to the closest point of the crack's triangles, if it is within `reach`."""
    places = place.copy().reshape(1, 3)
    found, _ = nearest_triangle(state, places, 0, 0.0, reach)
    if found >= 0:
        corners = np.empty((3, 3))
        for k in range(3):
            corners[k] = state.crack_points[state.crack_triangles[found, k]]
        _onto_facet(corners, places[0], place)


@kernel
def nearest_triangle(state, places, row, enough, reach):
    """Return the row of the triangle nearest to places[row], and the squared distance.

    Searched are state.crack_triangles, the crack as given. enough, reach: distances. The search ends at the
    first triangle found within `enough`. Returns -1 and inf if none is within `reach`.
    """
    points, triangles = state.crack_points, state.crack_triangles
    start, items, shape = state.crack_bin_start, state.crack_bin_items, state.crack_bin_shape
    grid = Grid(state.crack_bin_low, state.crack_bin_width[0], shape)
    found = np.int64(-1)
    best = reach * reach
    radius = min(reach, 0.5 * grid.width)
    while len(triangles) > 0:
        i0, i1, j0, j1, k0, k1 = cells_of_box(grid, places[row] - radius, places[row] + radius)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                cell = (i * shape[1] + j) * shape[2]
                for n in range(start[cell + k0], start[cell + k1 + 1]):
                    a, b, c = triangles[items[n]]
                    d = facet_distance2(points, a, b, c, places, row, best)
                    if d < best:
                        best = d
                        found = items[n]
                        if best <= enough * enough:
                            return found, best
        if radius >= reach or best <= radius * radius:
            break
        radius = min(2.0 * radius, reach)
    return found, best if found >= 0 else np.inf
