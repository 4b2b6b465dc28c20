"""The guards of the crack: its facets stay near the given crack, the edges of its front near the front.

Witnesses, initial positions attached to facets, bound the distance from the input's vertices to the
surface. These guards bound the opposite distance: from new crack facets, from new front edges, and from the
tip (the star's new or moved vertex) to the given crack and its front. Larger distances in the input remain.
"""

import numpy as np

from craftmesh.gradation.kernels.collapse_rules import is_front_edge
from craftmesh.gradation.kernels.projection import nearest_triangle
from craftmesh.gradation.kernels.result_codes import ON_CRACK, ON_FRONT
from craftmesh.gradation.kernels.star import old_facet
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import segment_distance2
from craftmesh.surface.rounding import ROUNDING

# Barycentric coordinates of the sampled points of a facet: all multiples of an eighth except the corners.
# With quarters instead, facets of rough cracks are up to a third farther away between the samples.
PLACES = np.array([(i, j, 8 - i - j) for i in range(8) for j in range(9 - i) if max(j, 8 - i - j) < 8]) / 8
# Search distance relative to the limit. Points farther from the given crack count as infinitely far; they
# exist because the insertion may have moved the crack.
FAR = 8.0


@kernel
def leaves_crack(state, star, limit):
    """Return whether a new crack facet is farther from the given crack than `limit` and than all old ones.

    The result is also True if the tip, the star's new or moved vertex, is too far (`_tip_leaves`), because
    a crack vertex may become a junction point off the crack. It is False for a flat crack.
    """
    if len(state.crack_triangles) == 0:
        return False
    worst = 0.0
    place = np.empty((1, 3))
    on_crack = False
    for i in range(star.moved):
        if state.patch_crack[state.patch[state.star[i]]]:
            on_crack = True
            worst = max(worst, _facet_off2(state, state.star_corners[i], limit, place))
    if on_crack and _tip_leaves(state, star, limit, place):
        return True
    if worst <= limit * limit:
        return False
    before = 0.0
    for i in range(star.moved + star.dying):
        f = old_facet(state, star, i)
        if state.patch_crack[state.patch[f]]:
            before = max(before, _facet_off2(state, state.facets[f], limit, place))
    return worst > (1.0 + ROUNDING) * before


@lean_kernel
def _tip_leaves(state, star, limit, place):
    """Return whether the tip, the new corner, is farther from the crack than `limit` and all old vertices.

    Old vertices are the star's vertices on the crack.
    """
    worst = _off2(state, star.tip, limit, place)
    if worst <= limit * limit:
        return False
    before = 0.0
    for v in (star.vertex, star.gone):
        if v >= 0 and state.flags[v] & ON_CRACK:
            before = max(before, _off2(state, v, limit, place))
    return worst > (1.0 + ROUNDING) * before


@lean_kernel
def _off2(state, vertex, limit, place):
    """Return the squared distance of a vertex from the given crack.

    limit: a distance, not squared. Vertices nearer than `limit` may get the squared distance of another
    triangle within `limit`; farther ones get the exact value, and inf beyond FAR times `limit`.
    """
    for k in range(3):
        place[0, k] = state.points[vertex, k]
    return nearest_triangle(state, place, 0, limit, FAR * limit)[1]


@lean_kernel
def _facet_off2(state, corners, limit, place):
    """Return the largest squared distance of the facet's sampled points from the crack.

    The distance of a point is exact only beyond `limit`, as in `_off2`.
    """
    worst = 0.0
    for n in range(len(PLACES)):
        for k in range(3):
            place[0, k] = 0.0
            for i in range(3):
                place[0, k] += PLACES[n, i] * state.points[corners[i], k]
        worst = max(worst, nearest_triangle(state, place, 0, limit, FAR * limit)[1])
    return worst


@kernel
def leaves_front(state, star, limit):
    """Return whether the midpoint of a new front edge is too far from the given front (state.front).

    Too far is farther than `limit`, a length, and than the midpoints of all old front edges at the star's
    vertices.
    """
    moves = star.tip != star.vertex or star.gone >= 0
    flags = state.flags[star.vertex] | (state.flags[star.gone] if star.gone >= 0 else 0)
    if not moves or not flags & ON_FRONT:
        return False
    worst = 0.0
    before = 0.0
    place = np.empty((1, 3))
    for v in (star.vertex, star.gone):
        if v < 0 or not state.flags[v] & ON_FRONT:
            continue
        c = state.first[v]
        while c >= 0:
            if state.patch_crack[state.patch[c // 3]]:
                for i in range(1, 3):
                    u = state.facets[c // 3, (c + i) % 3]
                    if state.flags[u] & ON_FRONT and is_front_edge(state, v, u):
                        before = max(before, _middle_off2(state, v, u, place))
                        if u != star.vertex and u != star.gone:
                            worst = max(worst, _middle_off2(state, star.tip, u, place))
            c = state.after[c]
    return worst > limit * limit and worst > (1.0 + ROUNDING) * before


@lean_kernel
def _middle_off2(state, a, b, place):
    """Return the squared distance of the midpoint of edge (a, b) from the front."""
    ends = state.front.reshape(-1, 3)
    for k in range(3):
        place[0, k] = 0.5 * (state.points[a, k] + state.points[b, k])
    least = np.inf
    for i in range(0, len(ends), 2):
        least = min(least, segment_distance2(ends, i, i + 1, place, 0))
    return least
