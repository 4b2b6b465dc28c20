"""Witnesses: first places of vertices that are gone or moved, each kept by the facet it lies nearest to.

They bound the distance from the input to the changed surface: an operation may only move a witness
out of its facet when one of the new facets (for a vertex of a junction line: one of the new junction
edges) passes it closely enough. A vertex of a trace of the crack is kept by a crack facet beside the
trace, which passes it as closely as any on the crack has to, while the trace itself may go as far along
the crack as junction lines go. Vertices made by splits have first places too, so that facets smaller
than the input's do not creep away from it between its vertices.
"""

import numpy as np

from craftmesh.gradation.kernels.rings import edge_facets
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import facet_distance2, segment_distance2

TOO_MANY = -1
# A facet within this part of the bound is near enough to end the search for a nearer one.
CLOSE = 0.3


@lean_kernel
def collect(state, f, count):
    """Append the witnesses of facet `f` to state.loose; return the new count or TOO_MANY."""
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
    """Append vertex `v`, near facet `f`, to state.loose unless its first place is a witness already."""
    if count == TOO_MANY or state.is_witness[v]:
        return count
    state.loose[count] = v
    state.loose_facet[count] = f
    return count + 1


@lean_kernel
def _mark_features(state, star, total):
    """Set star_feature: which edges of the star's new facets are features.

    Where a vertex moves or goes, an edge is what it was with the old corners in the same places. Where none
    does, as in a swap, corners change places, and an edge that is new lies inside its patch.
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
    """Tell whether (u, v) is an edge of the mesh as it stands and a feature."""
    count, f, g = edge_facets(state.facets, state.first, state.after, u, v)
    return count > 0 and (count != 2 or state.patch[f] != state.patch[g])


@lean_kernel
def _near_facet(points, star, corners, patches, patch, home, w, total, enough):
    """Return the least squared distance to the new facets of a patch, or the first under `enough`."""
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
    """Return the least squared distance to a feature of the new facet i, or `best` where that is less."""
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
    """Return the least squared distance to a feature of the new crack facets that are within `limit`."""
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
    """Find for each of the `loose` witnesses a near one of the star's facets; False if one is too far.

    reaches: the first is a part of the target length, be it the star's or the witness's own; of the vertex
    that moves it is the star's. The others are lengths, on the crack and on its front. The facets that may
    take witnesses are star[:takers]; loose_facet holds on entry the old facet, whose patch the new one must
    have, and on success the new one.
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
def settle(state, loose):
    """Hand the loose witnesses to the facets found for them."""
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
