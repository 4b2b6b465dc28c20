"""Nearest places on the input's crack and on its front, for vertices that are new or moved."""

import numpy as np

from craftmesh.gradation.kernels.codes import is_held
from craftmesh.jit import kernel

# Rounds of projection onto a curved crack and back onto the box's plane; they converge to the trace.
ROUNDS = 12


@kernel
def _onto_segment(p, q, place, found):
    d = q - p
    length2 = np.dot(d, d)
    t = 0.0
    if length2 > 0.0:
        t = min(1.0, max(0.0, np.dot(place - p, d) / length2))
    for k in range(3):
        found[k] = p[k] + t * d[k]
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


@kernel
def put_on_crack_in_box(state, planes, v, place):
    """Move `place` (3,) onto the crack with the coordinates that the bits of `planes` fix at vertex `v`."""
    for _ in range(ROUNDS):
        put_on_crack(state.crack_corners, state.crack_centre, state.crack_reach, place)
        if put_on_planes(state, planes, v, place) == 0.0:
            return


@kernel
def put_on_planes(state, planes, v, place):
    """Give `place` (3,) the coordinates that `planes` fix at vertex `v`; return how far off it was."""
    off = 0.0
    for k in range(3):
        if is_held(planes, k):
            off = max(off, abs(place[k] - state.points[v, k]))
            place[k] = state.points[v, k]
    return off


@kernel
def put_on_crack(corners, centre, reach, place):
    """Move `place` (3,) to the nearest point of the facets `corners` (c, 3, 3).

    Without facets (a flat crack) it stays. `centre` and `reach` are the facets' bounding spheres.
    """
    best = np.inf
    start = place.copy()
    trial = np.empty(3)
    for i in range(len(corners)):
        x = centre[i, 0] - start[0]
        y = centre[i, 1] - start[1]
        z = centre[i, 2] - start[2]
        far = np.sqrt(best) + reach[i]
        if x * x + y * y + z * z > far * far:
            continue
        d = _onto_facet(corners[i], start, trial)
        if d < best:
            best = d
            place[:] = trial
