"""Edge collapse on multi-material surfaces: the end that moves, its new position, and the checks.

The star is the set of facets that get new corners; the tip is the corner that they all share.
"""

import numpy as np

from craftmesh.gradation.kernels.collapse_rules import (
    EITHER,
    NEITHER,
    ONTO_B,
    closes_thin_end,
    end_on_box_edge,
    grains_touch,
    link_refusal,
    makes_chord,
    makes_ear,
    movable_end,
)
from craftmesh.gradation.kernels.cones import drift_allows, grain_cones, keep_volumes
from craftmesh.gradation.kernels.guards import attempt
from craftmesh.gradation.kernels.projection import put_on_planes
from craftmesh.gradation.kernels.result_codes import CHORD, DONE, EAR, GRAIN_CONTACT, LINK, ON_CRACK, VOLUME
from craftmesh.gradation.kernels.rings import is_feature
from craftmesh.gradation.kernels.star import Star, add_star, list_edge_facets
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import squared_distance

# Largest distance from the edge's midpoint at which a collapse may put the vertex to keep the grains'
# volumes: this fraction of the edge length plus this fraction of the target length, chosen by hand. If the
# volumes need a larger shift, the limit of volume drift decides.
REACH_OF_EDGE = 0.3
REACH_OF_TARGET = 0.05
# Ratio of length to target length below which an edge inside a patch is first collapsed onto an end, which
# does not keep volumes. These collapses may use only this fraction of the limit of volume drift; the rest
# is left to collapses that have no other position.
SHORT, DRIFT_OF_SHORT = 0.5, 0.1


@lean_kernel
def _star_of_merging(state, a, b, halfway):
    """Return the star, the facets that change, of merging `b` into `a`; star.moved is -1 if too many.

    halfway: whether `a` moves (its new position is set later); if not, it stays.
    """
    tip = state.used[0] if halfway else a
    dying = list_edge_facets(state, b, a)
    moved = add_star(state, b, a, tip, np.int64(0))
    size = state.size[a]
    if halfway:
        size = 0.5 * (size + state.size[b])
        state.size[tip] = size
        if moved >= 0:
            moved = add_star(state, a, b, tip, moved)
    if dying < 0:
        moved = np.int64(-1)
    return Star(a, tip, b, moved, dying, size)


@lean_kernel
def _put_halfway(state, star):
    """Put the star's tip, the new vertex, at the edge's midpoint, shifted to keep the grains' volumes."""
    a = star.vertex
    b = star.gone
    place = state.points[star.tip]
    for k in range(3):
        place[k] = 0.5 * (state.points[a, k] + state.points[b, k])
    length = np.sqrt(squared_distance(state.points, a, b))
    keep_volumes(state, star, state.flags[a], REACH_OF_EDGE * length + REACH_OF_TARGET * state.size[a])
    put_on_planes(state, state.flags[a], a, place)


@lean_kernel
def collapse(state, grid, limits, a, b, halfway, drift):
    """Merge `b` into `a`, at a's position or near the edge's midpoint; return DONE or the reason why not.

    halfway: whether the vertex moves near the midpoint. drift: for a collapse onto `a`, the largest
    relative change of a grain's volume, if less than limits.drift. The link condition, that the topology
    stays, must hold already (`link_refusal`, not checked here).
    """
    if makes_ear(state, a, b):
        return EAR
    if makes_chord(state, a, b):
        return CHORD
    star = _star_of_merging(state, a, b, halfway)
    if star.moved < 0:
        return LINK
    if halfway:
        _put_halfway(state, star)
    elif drift < limits.drift:
        grains = grain_cones(state, star, state.points[star.tip])
        if not drift_allows(state, grains, drift):
            return VOLUME
    return attempt(state, grid, limits, star, limits.floor, limits.gain)


@lean_kernel
def collapse_edge(state, grid, limits, a, b):
    """Collapse edge (a, b) if vertex classes, topology and guards allow it.

    Vertex classes are ranks and flags. Return DONE or the code of the reason why not (`result_codes`).
    """
    lines = state.rank[a] > 0 and state.rank[b] > 0
    feature = lines and is_feature(state.facets, state.patch, state.first, state.after, a, b)
    closing = limits.merge_points and lines and not feature and closes_thin_end(state, a, b)
    ends, reason = movable_end(
        state.rank[a],
        state.rank[b],
        state.flags[a],
        state.flags[b],
        feature or closing,
        limits.merge_points,
    )
    if ends == NEITHER and closing:
        ends = end_on_box_edge(state.flags[a], state.flags[b])
    if ends == NEITHER:
        return reason
    reason = link_refusal(state, a, b, closing, limits.merge_points)
    if reason != DONE:
        return reason
    if (closing or (state.rank[a] == 2 and state.rank[b] == 2)) and grains_touch(state, a, b):
        return GRAIN_CONTACT
    reason = _collapse_somehow(state, grid, limits, a, b, ends)
    if closing and reason == DONE:
        state.rank[a if state.first[b] < 0 else b] = 2
    return reason


@lean_kernel
def _collapse_somehow(state, grid, limits, a, b, ends):
    """Try to collapse the edge to its midpoint and onto the ends that `ends` allows, until one succeeds.

    Return DONE or the reason of the last refusal. Short edges inside a patch try their ends first, because
    a collapse onto an end changes fewer facets; other edges try the midpoint first.
    """
    reason = DONE
    halfway = ends == EITHER and not (state.flags[a] & ON_CRACK)
    reach = SHORT * 0.5 * (state.size[a] + state.size[b])
    late = halfway and state.rank[a] == 0 and squared_distance(state.points, a, b) < reach * reach
    drift = DRIFT_OF_SHORT * limits.drift if late else limits.drift
    if halfway and not late:
        reason = collapse(state, grid, limits, a, b, np.bool_(True), drift)
        if reason == DONE:
            return DONE
    if ends != ONTO_B:
        reason = collapse(state, grid, limits, a, b, np.bool_(False), drift)
    if ends == ONTO_B or (ends == EITHER and reason != DONE):
        reason = collapse(state, grid, limits, b, a, np.bool_(False), drift)
    if late and reason != DONE:
        reason = collapse(state, grid, limits, a, b, np.bool_(True), limits.drift)
    return reason
