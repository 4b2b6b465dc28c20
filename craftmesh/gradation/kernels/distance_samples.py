"""Witnesses: initial positions of removed or moved vertices, each attached to the nearest facet.

Witnesses bound the distance from the input to the changed surface. An operation may detach a witness from
its facet only if one of the new facets (for a vertex of a junction line: one of the new junction edges)
passes it closely enough. A trace is a line where the crack meets a grain boundary, a box plane or a void.
A witness on a trace is attached to a crack facet next to the trace. This facet must be as close as other
crack facets; the trace itself may be as far away as junction lines. Vertices made by splits have initial
positions too. Otherwise facets smaller than the input's would drift away between the input's vertices.
"""

import numpy as np

from craftmesh.gradation.kernels.rings import edge_facets
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import facet_distance2, segment_distance2

TOO_MANY = -1
# Fraction of the largest distance: a facet within it ends the search for a nearer one.
CLOSE = 0.3


@lean_kernel
def collect(state, f, count):
    """Append the witnesses (initial vertex positions) of facet `f` to state.loose; return their new number.

    count: number of witnesses in state.loose already, or TOO_MANY, which is returned unchanged. If
    there is no more room, TOO_MANY is returned.
    """
    if count == TOO_MANY:
        return TOO_MANY
    w = state.witness_first[f]
    if w < 0:
        return count
    loose, loose_facet, after = state.loose, state.loose_facet, state.witness_after
    while w >= 0:
        if count >= len(loose) - 4:
            return TOO_MANY
        loose[count] = w
        loose_facet[count] = f
        count += 1
        w = after[w]
    return count


@lean_kernel
def set_free(state, v, f, count):
    """Append vertex `v`, near facet `f`, to state.loose unless it is a witness; return the new count."""
    if count == TOO_MANY or state.is_witness[v]:
        return count
    state.loose[count] = v
    state.loose_facet[count] = f
    return count + 1


@lean_kernel
def _mark_features(state, star, total):
    """Set state.star_feature, a mask of feature edges, for the star's first `total` new facets.

    If a vertex moves or is removed, a new edge has the class of the old edge in the same position. In a
    swap no vertex moves, but corners change position, and a new edge is inside its patch.
    """
    stays = star.tip == star.vertex and star.gone < 0
    for i in range(total):
        f = state.star[i]
        corners = state.star_corners[i] if stays else state.facets[f]
        for k in range(3):
            u = corners[k]
            v = corners[(k + 1) % 3]
            state.star_feature[i, k] = state.rank[u] > 0 and state.rank[v] > 0 and _on_line(state, u, v)


@lean_kernel
def _on_line(state, u, v):
    """Return whether (u, v) is an edge of the current mesh and a feature."""
    count, f, g = edge_facets(state.facets, state.first, state.after, u, v)
    return count > 0 and (count != 2 or state.patch[f] != state.patch[g])


@lean_kernel
def _near_facet(points, star, corners, patches, patch, home, w, total, enough):
    """Return the squared distance of witness w from the nearest new facet of `patch`, and the facet's row.

    home[w] is the witness' position. A patch is a part of the surface between feature lines. New facet i <
    `total` replaces facet star[i], so its patch is patches[star[i]]; its corners are corners[i]. The search
    ends at the first squared distance under `enough`. Without a facet of the patch, returns inf, -1.
    """
    best = np.inf
    where = -1
    for i in range(total):
        if patches[star[i]] == patch:
            d = facet_distance2(points, corners[i, 0], corners[i, 1], corners[i, 2], home, w, best)
            if d < best:
                best = d
                where = i
                if best < enough:
                    break
    return best, where


@lean_kernel
def _nearest_side(state, w, i, best):
    """Return the smallest squared distance of witness w to new facet i's feature edges, at most `best`."""
    for k in range(3):
        if state.star_feature[i, k]:
            u = state.star_corners[i, k]
            v = state.star_corners[i, (k + 1) % 3]
            best = min(best, segment_distance2(state.points, u, v, state.home, w))
    return best


@lean_kernel
def _nearest_line(state, w, total):
    best = np.inf
    where = -1
    for i in range(total):
        d = _nearest_side(state, w, i, best)
        if d < best:
            best = d
            where = i
    return best, where


@lean_kernel
def _nearest_trace(state, w, total, limit):
    """Return a witness' squared distance to the nearest feature edge of new crack facets, and the row.

    Only crack facets within `limit` of the witness count; without one the result is inf, -1.
    """
    best = np.inf
    where = -1
    for i in range(total):
        if state.patch_crack[state.patch[state.star[i]]]:
            a, b, c = state.star_corners[i]
            if facet_distance2(state.points, a, b, c, state.home, w, np.inf) > limit * limit:
                continue
            d = _nearest_side(state, w, i, best)
            if d < best:
                best = d
                where = i
    return best, where


@lean_kernel
def find_new_homes(state, star, loose, takers, reaches):
    """Find a facet of the star for each of the `loose` witnesses; return False if one is too far away.

    A witness is the initial position of a vertex. reaches: three largest distances. The first is in target
    lengths, the star's or the witness' if less (for the moving vertex the star's); the second and third are
    lengths, for witnesses on the crack and on its front.
    Facets star[:takers] may get witnesses. On entry state.loose_facet has the old facet of each witness; on
    success it has the new facet. A witness inside a patch stays in the patch of its old facet.
    """
    points, facets, corners = state.points, state.star, state.star_corners
    mover = star.vertex if star.tip != star.vertex else -1
    patches, home = state.patch, state.home
    witness, found, own_size = state.loose, state.loose_facet, state.size
    on_crack, rank = state.witness_crack, state.witness_rank
    marked = False
    for n in range(loose):
        w = witness[n]
        patch = patches[found[n]]
        limit = reaches[0] * (star.size if w == mover else min(star.size, own_size[w]))
        on_trace = on_crack[w] and rank[w] == 1 and not state.witness_front[w]
        if on_crack[w] and not on_trace:
            limit = min(limit, reaches[1])
        if state.witness_front[w]:
            limit = min(limit, reaches[2])
        if rank[w] > 0:
            if not marked:
                _mark_features(state, star, takers)
                marked = True
            if on_trace:
                d, where = _nearest_trace(state, w, takers, reaches[1])
            else:
                d, where = _nearest_line(state, w, takers)
        else:
            enough = (CLOSE * limit) ** 2
            d, where = _near_facet(points, facets, corners, patches, patch, home, w, takers, enough)
        if where < 0 or d > limit * limit:
            return False
        found[n] = facets[where]
    return True


@lean_kernel
def attach_witnesses(state, loose):
    """Attach each of the first `loose` witnesses in state.loose to its new facet, state.loose_facet.

    Witnesses are initial vertex positions; loose ones have lost their facet in the current operation, and
    `find_new_homes` has set their new one.
    """
    if loose == 0:
        return
    witness, found, is_witness = state.loose, state.loose_facet, state.is_witness
    first, after = state.witness_first, state.witness_after
    for n in range(loose):
        w = witness[n]
        f = found[n]
        is_witness[w] = True
        after[w] = first[f]
        first[f] = w
