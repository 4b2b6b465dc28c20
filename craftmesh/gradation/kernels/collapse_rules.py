"""Which edges may collapse at all: vertex classes, topology of the junctions, ears on the crack front."""

from craftmesh.gradation.kernels.codes import (
    CONSTRAINT,
    DONE,
    JUNCTION,
    JUNCTION_TRIANGLE,
    LINK,
    ON_CRACK,
    ON_FRONT,
    ON_PLANES,
)
from craftmesh.gradation.kernels.rings import edge_facets, has_corner, is_feature, third_corner
from craftmesh.jit import lean_kernel

# Which end of an edge may move: neither, the second onto the first, the first onto the second, both.
NEITHER, ONTO_A, ONTO_B, EITHER = range(4)


@lean_kernel
def movable_end(rank_a, rank_b, flags_a, flags_b, feature, merge_points):
    """Return which end of an edge may give way, and on NEITHER the reason.

    The end of higher rank stays; between ends of one rank the one with more box planes stays.
    """
    if rank_a > 0 and rank_b > 0 and not feature:
        return NEITHER, JUNCTION
    if rank_a == 2 and rank_b == 2 and not merge_points:
        return NEITHER, JUNCTION
    a_covers_b = (flags_a & flags_b) == flags_b
    b_covers_a = (flags_a & flags_b) == flags_a
    onto_a = rank_a >= rank_b and a_covers_b
    onto_b = rank_b >= rank_a and b_covers_a
    if onto_a and onto_b:
        return EITHER, DONE
    if onto_a:
        return ONTO_A, DONE
    if onto_b:
        return ONTO_B, DONE
    return NEITHER, CONSTRAINT


@lean_kernel
def end_on_box_edge(flags_a, flags_b):
    """Return which end of an edge between a box edge and the crack's mouth beside it may give way.

    The mouth's point leaves the crack for the box edge; how far is for the guards to allow.
    """
    for flags, other, ends in ((flags_a, flags_b, ONTO_A), (flags_b, flags_a, ONTO_B)):
        mouth = other & ~ON_CRACK
        if other & ON_CRACK and mouth & ON_PLANES and flags & mouth == mouth and flags & ~ON_CRACK > mouth:
            return ends
    return NEITHER


@lean_kernel
def closes_thin_end(state, a, b):
    """Tell whether the edge inside a patch, between two of its border lines, is next to where these meet.

    Merging such an edge closes the thin end of the patch: one facet between the two lines goes, and its
    two border edges become one, which no side may then bound with more than two facets.
    """
    if state.flags[a] & state.flags[b] & ON_CRACK:
        return False
    count, f, g = edge_facets(state.facets, state.first, state.after, a, b)
    if count != 2 or state.patch[f] != state.patch[g]:
        return False
    u = third_corner(state.facets, f, a, b)
    v = third_corner(state.facets, g, a, b)
    if _between_lines(state, a, b, u) == _between_lines(state, a, b, v):
        return False
    return _lines_may_join(state, a, b, u if _between_lines(state, a, b, u) else v)


@lean_kernel
def _lines_may_join(state, a, b, tip):
    """Tell whether edges (a, tip) and (b, tip) may become one, no side having over two facets on it."""
    for end, other in ((a, b), (b, a)):
        c = state.first[end]
        while c >= 0:
            for k in range(2):
                side = state.patch_sides[state.patch[c // 3], k]
                here = _facets_of_side(state, end, other, tip, side)
                if here + _facets_of_side(state, other, end, tip, side) > 2:
                    return False
            c = state.after[c]
    return True


@lean_kernel
def _between_lines(state, a, b, u):
    facets, patch, first, after = state.facets, state.patch, state.first, state.after
    if state.rank[u] == 0:
        return False
    return is_feature(facets, patch, first, after, a, u) and is_feature(facets, patch, first, after, b, u)


@lean_kernel
def _facets_of_side(state, a, b, u, side):
    """Return how many facets on edge (a, u), but not at `b`, bound the side."""
    count = 0
    c = state.first[a]
    while c >= 0:
        f = c // 3
        both = state.patch_sides[state.patch[f]]
        if (both[0] == side) != (both[1] == side):
            if has_corner(state.facets, f, u) and not has_corner(state.facets, f, b):
                count += 1
        c = state.after[c]
    return count


@lean_kernel
def link_refusal(state, a, b, closing, merge_points):
    """Return why merging (a, b) would change the topology, or DONE.

    Vertices joined to both ends must be corners of facets on the edge (link condition), and none of
    these may be joined to both by feature edges, or two junction lines would fall into one; unless
    `closing` (closes_thin_end), or where junction points may merge and the facet between the lines is a
    remnant (_is_remnant).
    """
    facets, first, after, stamp = state.facets, state.first, state.after, state.stamp
    mark = state.clock[0] + 1
    state.clock[0] += 2
    c = first[a]
    while c >= 0:
        stamp[facets[c // 3, (c + 1) % 3]] = mark
        stamp[facets[c // 3, (c + 2) % 3]] = mark
        c = after[c]
    shared = 0
    c = first[b]
    while c >= 0:
        f = c // 3
        if has_corner(facets, f, a):
            shared += 1
            u = third_corner(facets, f, a, b)
            if stamp[u] == mark + 1:
                return LINK
            stamp[u] = mark + 1
            if not closing and state.rank[a] > 0 and state.rank[b] > 0 and _between_lines(state, a, b, u):
                if not (merge_points and _is_remnant(state, f, a, b, u)):
                    return JUNCTION_TRIANGLE
        c = after[c]
    if shared == 0:
        return LINK
    c = first[b]
    while c >= 0:
        for i in range(1, 3):
            u = facets[c // 3, (c + i) % 3]
            if u != a and stamp[u] == mark:
                return LINK
        c = after[c]
    if _twin_facet(state, a, b, mark + 1):
        return LINK
    return DONE


@lean_kernel
def _is_remnant(state, f, a, b, u):
    """Tell whether facet f = (a, b, u) may close, for its contact goes on beyond one of the joining lines.

    So is the part of a contact that a crack leaves behind itself where a triple line grazes it.
    """
    if state.rank[a] < 2 or state.rank[b] < 2 or state.rank[u] < 2:
        return False
    if state.flags[a] & state.flags[b] & ON_CRACK:
        return False
    patch = state.patch[f]
    beyond = _facets_of_patch(state, a, u, patch) + _facets_of_patch(state, b, u, patch) - 2
    alone = _facets_of_patch(state, a, b, patch) == 1
    return alone and beyond == 1 and _lines_may_join(state, a, b, u)


@lean_kernel
def _facets_of_patch(state, a, b, patch):
    count = 0
    c = state.first[a]
    while c >= 0:
        if state.patch[c // 3] == patch and has_corner(state.facets, c // 3, b):
            count += 1
        c = state.after[c]
    return count


@lean_kernel
def _twin_facet(state, a, b, mark):
    """Tell whether a facet at `a` and one at `b` would become the same facet."""
    facets, stamp, first, after = state.facets, state.stamp, state.first, state.after
    c = first[a]
    while c >= 0:
        u = facets[c // 3, (c + 1) % 3]
        v = facets[c // 3, (c + 2) % 3]
        if u != b and v != b and stamp[u] == mark and stamp[v] == mark:
            d = first[b]
            while d >= 0:
                if has_corner(facets, d // 3, u) and has_corner(facets, d // 3, v):
                    return True
                d = after[d]
        c = after[c]
    return False


@lean_kernel
def grains_touch(state, a, b):
    """Tell whether a side or a patch that the edge does not bound has both ends, so that it would tie."""
    c = state.first[a]
    while c >= 0:
        patch = state.patch[c // 3]
        sides = state.patch_sides[patch]
        if (
            _ends_meet(state, a, b, patch, -2)
            or _ends_meet(state, a, b, -1, sides[0])
            or _ends_meet(state, a, b, -1, sides[1])
        ):
            return True
        c = state.after[c]
    return False


@lean_kernel
def _ends_meet(state, a, b, patch, side):
    """Tell whether `b` has facets of the patch, or of the side, of which none has `a` too."""
    found = False
    d = state.first[b]
    while d >= 0:
        g = d // 3
        both = state.patch_sides[state.patch[g]]
        if state.patch[g] == patch or both[0] == side or both[1] == side:
            if has_corner(state.facets, g, a):
                return False
            found = True
        d = state.after[d]
    return found


@lean_kernel
def is_front_edge(state, a, b):
    """Tell whether (a, b) is a front edge: one crack facet on it, none of the exterior or a void."""
    crack = 0
    c = state.first[a]
    while c >= 0:
        if has_corner(state.facets, c // 3, b):
            patch = state.patch[c // 3]
            if state.patch_free[patch]:
                return False
            if state.patch_crack[patch]:
                crack += 1
        c = state.after[c]
    return crack == 1


@lean_kernel
def makes_ear(state, a, b):
    """Tell whether moving `b` onto the front vertex `a` makes an ear: joins it to another front vertex.

    See craftmesh.surface.front; an edge that is or becomes the front itself is none.
    """
    if not (state.flags[a] & ON_FRONT):
        return False
    c = state.first[b]
    while c >= 0:
        f = c // 3
        if state.patch_crack[state.patch[f]] and not has_corner(state.facets, f, a):
            for i in range(1, 3):
                u = state.facets[f, (c + i) % 3]
                if state.flags[u] & ON_FRONT:
                    if not is_front_edge(state, b, u) and not is_front_edge(state, a, u):
                        return True
        c = state.after[c]
    return False
