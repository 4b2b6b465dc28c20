"""Edge split on multi-material surfaces: all facets on the edge are split and keep sides and patch.

The parents are the facets on the edge; each is replaced by two halves at the new vertex.
"""

import numpy as np

from craftmesh.gradation.kernels.collapse_rules import is_front_edge
from craftmesh.gradation.kernels.cones import book_drift, grain_cones
from craftmesh.gradation.kernels.distance_samples import TOO_MANY, attach_witnesses, collect, find_new_homes
from craftmesh.gradation.kernels.facet_grid import insert_facet
from craftmesh.gradation.kernels.guards import refusal, replace_corner
from craftmesh.gradation.kernels.projection import put_on_crack_in_box, put_on_front, put_on_planes
from craftmesh.gradation.kernels.result_codes import (
    ANGLE,
    CONSTRAINT,
    DONE,
    LINK,
    NO_NEED,
    ON_CRACK,
    ON_FRONT,
    ON_PLANES,
)
from craftmesh.gradation.kernels.star import Star, list_edge_facets
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.corner_lists import link_corner
from craftmesh.surface.kernels.facet_shape import angle_score


@lean_kernel
def _edge_class(state, a, b, parents):
    """Return the rank and flags of a new vertex on edge (a, b).

    The rank is 0 in a patch and 1 on a line of feature edges; flags are bits for box planes, crack and
    front. parents: number of facets on the edge, which are in state.dying.
    """
    flags = state.flags[a] & state.flags[b] & ON_PLANES
    rank = 0
    for i in range(parents):
        patch = state.patch[state.dying[i]]
        if patch != state.patch[state.dying[0]]:
            rank = 1
        if state.patch_crack[patch]:
            flags |= ON_CRACK
    if flags & ON_CRACK and is_front_edge(state, a, b):
        flags |= ON_FRONT
    return (1 if parents != 2 else rank), flags


@kernel
def _split_place(state, a, b, flags, place):
    """Set `place` (3,) to the edge's midpoint, put on crack, front and box planes; return if that moved it.

    flags: of the new vertex, which say where it must be.
    """
    for k in range(3):
        place[k] = 0.5 * state.points[a, k] + 0.5 * state.points[b, k]
    middle = place.copy()
    if flags & ON_FRONT:
        put_on_front(state.front, place)
    elif flags & ON_CRACK:
        put_on_crack_in_box(state, flags, a, place)
    put_on_planes(state, flags, a, place)
    return (place[0] - middle[0]) ** 2 + (place[1] - middle[1]) ** 2 + (place[2] - middle[2]) ** 2 > 0.0


@lean_kernel
def _set_halves(state, a, b, m, parents):
    """Write the halves of each parent facet into the star, first the half at `a`; m: the new vertex."""
    for i in range(parents):
        f = state.dying[i]
        for k in range(3):
            u = state.facets[f, k]
            state.star[2 * i] = f
            state.star[2 * i + 1] = f
            state.star_corners[2 * i, k] = m if u == b else u
            state.star_corners[2 * i + 1, k] = m if u == a else u


@lean_kernel
def _shapes_allow(state, parents, floor, share):
    """Return whether every half facet has the angle score `floor`, or `share` times its parent's if less.

    parents: number of facets on the edge, each of which becomes two halves.
    """
    for i in range(2 * parents):
        p, q, r = state.facets[state.dying[i // 2]]
        old = angle_score(state.points, p, q, r)
        p, q, r = state.star_corners[i]
        if angle_score(state.points, p, q, r) < min(floor, share * old):
            return False
    return True


@kernel
def _add_vertex(state, rank, flags):
    """Add a vertex to the surface, in the first free row, where its position and size are set already."""
    m = state.used[0]
    state.rank[m] = rank
    state.flags[m] = flags
    state.home[m] = state.points[m]
    state.witness_rank[m] = rank
    state.witness_crack[m] = (flags & ON_CRACK) > 0
    state.witness_front[m] = (flags & ON_FRONT) > 0
    state.is_witness[m] = False
    state.used[0] += 1


@kernel
def _divide(state, f, g, a, b, m):
    """Turn facet `f` into its half at `a` and the new facet `g` into its half at `b`."""
    facets = state.facets
    for k in range(3):
        u = facets[f, k]
        facets[g, k] = m if u == a else u
        link_corner(state.first, state.after, facets[g, k], 3 * g + k)
    for k in range(3):
        if facets[f, k] == b:
            replace_corner(state, f, k, m)
    state.alive[g] = True
    state.changed[f] = True
    state.changed[g] = True
    state.facet_stamp[g] = 0
    state.patch[g] = state.patch[f]
    state.reference[g] = state.reference[f]


@kernel
def _share_witnesses(state, f, g, m):
    """Attach each witness of facet `f`, an initial vertex position, to the nearer half, `f` or `g`.

    m: the new vertex of the halves. If there are too many witnesses, all stay at `f`.
    """
    loose = collect(state, f, np.int64(0))
    if loose == TOO_MANY:
        return
    state.witness_first[f] = -1
    state.witness_first[g] = -1
    state.star[0] = f
    state.star[1] = g
    state.star_corners[0] = state.facets[f]
    state.star_corners[1] = state.facets[g]
    for n in range(loose):
        state.loose_facet[n] = f
    halves = Star(m, m, np.int64(-1), np.int64(2), np.int64(0), np.inf)
    find_new_homes(state, halves, loose, np.int64(2), (np.inf, np.inf, np.inf))
    attach_witnesses(state, loose)


@lean_kernel
def _enter(state, grid, f):
    p, q, r = state.facets[f, 0], state.facets[f, 1], state.facets[f, 2]
    insert_facet(grid, state.points, f, p, q, r, state.patch[f])


@lean_kernel
def _commit_split(state, grid, a, b, parents, moved):
    """Divide the facets in state.dying at the newest vertex, and enter the halves in the grid if needed.

    moved: whether the vertex lies off the edge.
    """
    m = state.used[0] - 1
    for i in range(parents):
        f = state.dying[i]
        _divide(state, f, state.used[1], a, b, m)
        state.used[1] += 1
    for i in range(parents):
        f = state.dying[i]
        g = state.used[1] - parents + i
        _share_witnesses(state, f, g, m)
        _enter(state, grid, g)
        if moved:
            _enter(state, grid, f)


@lean_kernel
def split(state, grid, limits, a, b, share):
    """Split edge (a, b) if the halves are good enough; return DONE or the reason why not.

    A half needs the angle score limits.floor, or `share` times its parent's score if that is less. The
    score is 0 for a degenerate facet, 1 at a smallest angle of 15 or a largest of 135 degrees, and more for
    better facets. If the new vertex was moved onto the crack or its front, all checks of `guards.refusal`
    apply too. If not, the halves lie in their parents, so normals and intersections need no check.
    """
    m = state.used[0]
    parents = list_edge_facets(state, a, b)
    if parents <= 0:
        return LINK if parents < 0 else NO_NEED
    for i in range(parents):
        if state.patch_border[state.patch[state.dying[i]]]:
            return CONSTRAINT
    rank, flags = _edge_class(state, a, b, parents)
    moved = _split_place(state, a, b, flags, state.points[m])
    _set_halves(state, a, b, m, parents)
    if not _shapes_allow(state, parents, limits.floor, share):
        return ANGLE
    state.size[m] = 0.5 * state.size[a] + 0.5 * state.size[b]
    if moved:
        halves = Star(m, m, np.int64(-1), 2 * parents, np.int64(0), state.size[m])
        reason = refusal(state, grid, limits, halves, -np.inf, 0.0)
        if reason != DONE:
            return reason
        whole = Star(m, m, np.int64(-1), np.int64(0), parents, state.size[m])
        book_drift(state, grain_cones(state, whole, state.points[m]))
    _add_vertex(state, rank, flags)
    _commit_split(state, grid, a, b, parents, moved)
    return DONE
