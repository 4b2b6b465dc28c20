"""Rules for edges that may collapse: vertex classes, topology of junctions, ears and chords."""

import numpy as np

from craftmesh.gradation.kernels.result_codes import (
    CONSTRAINT,
    DONE,
    JUNCTION,
    JUNCTION_TRIANGLE,
    LINK,
    ON_BORDER,
    ON_CRACK,
    ON_FRONT,
    ON_PLANES,
)
from craftmesh.gradation.kernels.rings import edge_facets, has_corner, is_feature, third_corner
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import facet_distance2, squared_distance

# Codes for the end of an edge (a, b) that may move: neither, b onto a, a onto b, either one.
NEITHER, ONTO_A, ONTO_B, EITHER = range(4)
# Distance from the crack, relative to its length, below which an edge between crack vertices runs along it.
# Edges at poor tetrahedra were within 0.004 to 0.073; edges across kinks of sound meshes at 0.19 or more.
ALONG_CRACK = 0.15


@lean_kernel
def movable_end(rank_a, rank_b, flags_a, flags_b, feature, merge_points):
    """Return the code of the end of an edge that may move, and the reason if that is NEITHER, else DONE.

    feature: whether the edge may collapse along a line of feature edges. An end may move onto the other if
    the other has at least the same rank (0 in a patch, 1 on a line, 2 at a junction) and all of the first
    one's flags (box planes, crack, front). merge_points: whether two junctions may merge.
    """
    if rank_a > 0 and rank_b > 0 and not feature:
        return NEITHER, JUNCTION
    if rank_a == 2 and rank_b == 2 and not merge_points:
        return NEITHER, JUNCTION
    if flags_a & flags_b & ON_BORDER:
        return NEITHER, CONSTRAINT
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
    """Return the end that may move if the edge joins a box edge and the crack mouth, else NEITHER.

    The mouth is the line where the crack meets a box plane. Its vertex may move off the crack onto a vertex
    on more box planes; the guards decide later whether that is too far.
    """
    for flags, other, ends in ((flags_a, flags_b, ONTO_A), (flags_b, flags_a, ONTO_B)):
        mouth = other & ~ON_CRACK
        if other & ON_CRACK and mouth & ON_PLANES and flags & mouth == mouth and flags & ~ON_CRACK > mouth:
            return ends
    return NEITHER


@lean_kernel
def closes_thin_end(state, a, b):
    """Return whether edge (a, b) is inside a patch and crosses its thin end, between two border lines.

    One of the two facets on the edge must have feature edges as its other two edges. A collapse removes
    this facet and merges these two edges; the merged edge may have at most two facets of each side (grain
    or void). The result is False for an edge with both ends on the crack.
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
    """Return whether edges (a, tip) and (b, tip) may merge into one edge.

    The merged edge may have at most two facets that bound each grain or void.
    """
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
    """Return the number of facets on edge (a, u), without corner `b`, that bound the grain or void `side`.

    side: its slot, an index of grains and voids. Facets with it on both sides do not count.
    """
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
    """Return the reason why merging (a, b) would change the topology, or DONE.

    Each vertex joined to both ends must be a corner of a facet on the edge (link condition). None of these
    corners may be joined to both ends by feature edges, because two junction lines would merge. That is
    allowed if `closing` (the edge crosses the thin end of a patch, `closes_thin_end`), or if `merge_points`
    is true and the facet between the lines is a remnant of a patch (`_is_remnant`).
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
    """Return whether facet f = (a, b, u) is the remnant of a patch, which may close.

    A remnant has three junction vertices (rank 2) and no other facet of its patch on edge (a, b); beyond
    exactly one of the edges (a, u) and (b, u) its patch continues, by one facet. A crack leaves a remnant
    of a grain contact where it passes close along a triple line.
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
    """Return whether a facet at `a` and a facet at `b` would become the same facet."""
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
    """Return whether merging `a` and `b` would make a grain, void or patch touch itself in a vertex.

    That happens if the grain, void or patch has facets at both ends but none on the edge (a, b).
    """
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
    """Return whether `b` has facets of the patch or grain or void `side`, none of them with corner `a`."""
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
    """Return whether (a, b) is a front edge: one crack facet and no facet of the exterior or a void."""
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
    """Return whether moving `b` onto `a` makes an ear: an inner crack edge between two front vertices.

    An ear cannot open (craftmesh.surface.front). The result is False if `a` is not on the front. An edge
    that is or becomes a front edge is not an ear.
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


@lean_kernel
def makes_chord(state, a, b):
    """Return whether moving `b` onto `a` makes a chord, an edge off the crack along it (`is_along_crack`).

    Between a chord and the crack is only room for flat tets. Chords that are there already may stay.
    """
    if not (state.flags[a] & ON_CRACK):
        return False
    c = state.first[b]
    while c >= 0:
        f = c // 3
        for i in range(1, 3):
            u = state.facets[f, (c + i) % 3]
            if u != a and state.flags[u] & ON_CRACK and not is_crack_edge(state, b, u):
                if edge_facets(state.facets, state.first, state.after, a, u)[0] == 0:
                    if is_along_crack(state, a, u):
                        return True
        c = state.after[c]
    return False


@lean_kernel
def is_crack_edge(state, a, b):
    """Return whether a crack facet has the edge (a, b)."""
    c = state.first[a]
    while c >= 0:
        if state.patch_crack[state.patch[c // 3]] and has_corner(state.facets, c // 3, b):
            return True
        c = state.after[c]
    return False


@kernel
def is_along_crack(state, a, b):
    """Return whether an edge between crack vertices is within ALONG_CRACK of crack facets at its ends.

    The distance is that of its midpoint, relative to the edge's length.
    """
    points, facets = state.points, state.facets
    middle = np.empty((1, 3))
    for k in range(3):
        middle[0, k] = 0.5 * (points[a, k] + points[b, k])
    nearest = np.inf
    for v in (a, b):
        c = state.first[v]
        while c >= 0:
            f = c // 3
            if state.patch_crack[state.patch[f]]:
                nearest = facet_distance2(
                    points, facets[f, 0], facets[f, 1], facets[f, 2], middle, 0, nearest
                )
            c = state.after[c]
    return nearest < ALONG_CRACK * ALONG_CRACK * squared_distance(points, a, b)
