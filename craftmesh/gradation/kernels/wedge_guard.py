"""The guard of wedges: no change makes a wedge that is sharper than the limit and than all old ones.

A wedge is the dihedral angle between two neighbouring facets at an edge, on a junction line or inside a
patch, where it is a fold. Cosines stand for angles: the sharper the wedge, the larger the cosine. The star
is the set of facets that an operation changes; the tip is the corner that all new facets share.
"""

import numpy as np

from craftmesh.gradation.kernels.star import old_facet
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector
from craftmesh.surface.kernels.hinges import OPEN, sharpest_on_facet
from craftmesh.surface.rounding import EXACT


@lean_kernel
def sharpens_wedge(state, star, sheet, cosine):
    """Return whether a wedge at the star's new facets is sharper than `cosine` and than all old wedges.

    A wedge is the angle between two facets at an edge; a larger cosine is sharper. The rows of the new
    facets must be set (set_rows). Facets of a sheet, a star with similar normals in one patch, can enclose
    sharp wedges only on junction lines, so only these are checked.
    """
    alone = sheet.patch >= 0
    state.clock[1] += 1
    mark = state.clock[1]
    for i in range(star.moved):
        state.facet_stamp[state.star[i]] = mark
    for i in range(star.dying):
        state.facet_stamp[state.dying[i]] = mark
    sharpest = OPEN
    for i in range(star.moved):
        if alone and not _is_on_line(state, star, i):
            continue
        if not alone:
            sharpest = max(sharpest, _among_new(state, i))
        sharpest = max(sharpest, _at_its_rim(state, star.tip, i, mark))
        if star.tip == star.vertex:
            sharpest = max(sharpest, _at_last_spoke(state, star.tip, i, mark))
    return sharpest > cosine and sharpest > _sharpest_before(state, star) + EXACT


@lean_kernel
def _is_on_line(state, star, i):
    """Return whether two corners of the new facet in row `i` may lie on one junction line."""
    ranks = state.rank[star.vertex], state.rank[state.star_ends[i, 0]], state.rank[state.star_ends[i, 1]]
    return (ranks[0] > 0) + (ranks[1] > 0) + (ranks[2] > 0) > 1


@lean_kernel
def _among_new(state, i):
    """Return the largest cosine of the wedges between new facet `i` and new facets before it."""
    ends = state.star_ends
    normal = state.star_normal
    largest = OPEN
    for j in range(i):
        same = ends[i, 0] == ends[j, 0] or ends[i, 1] == ends[j, 1]
        if same or ends[i, 0] == ends[j, 1] or ends[i, 1] == ends[j, 0]:
            along = normal[i, 0] * normal[j, 0] + normal[i, 1] * normal[j, 1] + normal[i, 2] * normal[j, 2]
            largest = max(largest, along if same else -along)
    return largest


@lean_kernel
def _at_its_rim(state, tip, i, mark):
    """Return the largest cosine of the wedges between new facet `i` and unmarked facets on two edges.

    These are the edge from the tip to the facet's first end, and the edge opposite the tip. Marked facets
    (facet_stamp equal to `mark`) belong to the star.
    """
    u = state.star_ends[i, 0]
    v = state.star_ends[i, 1]
    largest = OPEN
    c = state.first[u]
    while c >= 0:
        f = c // 3
        ahead = state.facets[f, (c + 1) % 3]
        behind = state.facets[f, (c + 2) % 3]
        if (ahead == v or behind == v or ahead == tip or behind == tip) and state.facet_stamp[f] != mark:
            way = 1.0 if ahead == v or behind == tip else -1.0
            largest = max(largest, way * _along(state, i, f))
        c = state.after[c]
    return largest


@lean_kernel
def _at_last_spoke(state, tip, i, mark):
    """Return the same as `_at_its_rim`, a largest cosine, for the edge from the tip to the second end."""
    largest = OPEN
    c = state.first[state.star_ends[i, 1]]
    while c >= 0:
        f = c // 3
        ahead = state.facets[f, (c + 1) % 3]
        if (ahead == tip or state.facets[f, (c + 2) % 3] == tip) and state.facet_stamp[f] != mark:
            largest = max(largest, (1.0 if ahead == tip else -1.0) * _along(state, i, f))
        c = state.after[c]
    return largest


@lean_kernel
def _along(state, i, f):
    """Return the cosine between the normals of the new facet in row `i` and of facet `f`."""
    x, y, z = area_vector(state.points, state.facets[f, 0], state.facets[f, 1], state.facets[f, 2])
    size = np.sqrt(x * x + y * y + z * z)
    if size == 0.0:
        return 0.0
    return (x * state.star_normal[i, 0] + y * state.star_normal[i, 1] + z * state.star_normal[i, 2]) / size


@lean_kernel
def _sharpest_before(state, star):
    """Return the largest cosine of the wedges, angles between facets, at edges of the old facets."""
    largest = OPEN
    for i in range(star.moved + star.dying):
        f = old_facet(state, star, i)
        largest = max(largest, sharpest_on_facet(state.points, state.facets, state.first, state.after, f))
    return largest
