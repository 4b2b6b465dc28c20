"""One pass of the gradation: an operation is tried at a list of edges or vertices.

One kernel serves all operations, so that the guards are compiled only once.
"""

import numpy as np

from craftmesh.gradation.kernels.collapse import collapse_edge
from craftmesh.gradation.kernels.facet_grid import has_room
from craftmesh.gradation.kernels.relax import relax_vertex
from craftmesh.gradation.kernels.result_codes import NO_NEED, counted
from craftmesh.gradation.kernels.slide import even_vertex, slide_vertex
from craftmesh.gradation.kernels.split import split
from craftmesh.gradation.kernels.swap import MOST_WAITING, swap_round
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import squared_distance

# Operations on edges.
COLLAPSE, SPLIT, SWAP = range(3)
# Operations on vertices.
SLIDE, EVEN, RELAX = range(3, 6)


@lean_kernel
def _times_target2(state, a, b, times):
    """Return the square of `times` the edge's target length, the mean of the targets of its ends."""
    limit = times * 0.5 * (state.size[a] + state.size[b])
    return limit * limit


@lean_kernel
def _at_edge(state, grid, limits, operation, a, b, share):
    """Try COLLAPSE or SPLIT at edge (a, b) by its length; return DONE, NO_NEED or the reason of refusal.

    share: for SPLIT, smallest ratio of the angle score of a half facet to that of the facet that is split.
    """
    if operation == COLLAPSE:
        if squared_distance(state.points, a, b) < _times_target2(state, a, b, limits.collapse):
            return collapse_edge(state, grid, limits, a, b)
    elif squared_distance(state.points, a, b) > _times_target2(state, a, b, limits.split):
        return split(state, grid, limits, a, b, share)
    return NO_NEED


@lean_kernel
def _at_vertex(state, grid, limits, operation, v, goal):
    """Try an operation at vertex `v`; return DONE, the reason of refusal, or NO_NEED.

    SLIDE is tried at vertices inside a patch or on a line of feature edges, EVEN only on such a line, RELAX
    only inside a patch. goal: for SLIDE, the smallest angle score of the facets at `v` below which it
    moves.
    """
    rank = state.rank[v]
    if operation == SLIDE and rank < 2:
        return slide_vertex(state, grid, limits, v, goal)
    if operation == EVEN and rank == 1:
        return even_vertex(state, grid, limits, v)
    if operation == RELAX and rank == 0:
        return relax_vertex(state, grid, limits, v)
    return NO_NEED


@lean_kernel
def _has_room(state, grid, operation):
    """Return whether the grid, and for a split also the mesh's arrays, have room for one more operation."""
    if operation == SPLIT:
        if state.used[0] + 2 > len(state.points) or state.used[1] + len(state.dying) > len(state.facets):
            return False
    return has_room(grid)


@kernel
def one_pass(state, grid, limits, operation, items, goal, start):
    """Try `operation` at the edges (n, 2) or vertices (n, 1) `items`, from row `start` on.

    goal: for SLIDE the angle score below which a vertex moves; for SPLIT the smallest score of a half facet
    relative to its parent. Return the row at which the pass stopped, which is n, or less if grid or arrays
    need room, and the number of operations done. Refusals are counted by reason.
    """
    done = 0
    waiting = np.empty((MOST_WAITING, 2), np.int64)
    for n in range(start, len(items)):
        if not _has_room(state, grid, operation):
            return n, done
        a = items[n, 0]
        b = items[n, items.shape[1] - 1]
        if state.first[a] < 0 or state.first[b] < 0:
            continue
        if operation == SWAP:
            done += swap_round(state, grid, limits, a, b, waiting)
        elif operation < SLIDE:
            done += counted(state.refused, _at_edge(state, grid, limits, operation, a, b, goal))
        else:
            done += counted(state.refused, _at_vertex(state, grid, limits, operation, a, goal))
    return len(items), done
