"""A mesh under change: stars, rings, and cavity replacement, the only change of its topology.

The star of a point is the set of tets with this corner; the ring of an edge is the cycle of tets around it;
a cavity is a set of tets that is replaced by others with the same outer faces.
"""

from collections import namedtuple

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.kernel_structs import by_reference
from craftmesh.tetrahedra.kernels.tet_ratio_sums import TABLE_ROWS

# A mesh under change. Arrays are longer than the mesh; counts = [points, tets, free slots, last stamp].
# A slot is a row of the arrays of tets; a stamp is a number that marks the tets of one search.
# points (n, 3); tets (m, 4) with positive volumes, corner 0 is -1 in a dead slot; neighbours (m, 4)
# across the face opposite each corner, -1 if there is none, -2 - u if tet u is beyond a surface facet;
# tet_of (n,) a live tet of each point or -1; quality (m,); size (n,) target edge lengths; frozen
# (n,) mask of points that stay; free (m,) stack of dead slots; mark (m,) stamps; label (m,) the grain.
# The first s points lie on the surface: they move from home (s + 1, 3) by at most reach (s + 1,) along the
# rows of ways (s + 1, 3, 3), which are orthonormal or 0. The last row of these arrays is for all other
# points.
TetState = namedtuple(
    "TetState", "points tets neighbours tet_of quality size frozen counts free mark label home ways reach"
)
POINTS, TETS, FREE, STAMP = range(4)

# Work arrays: tets of a star; faces of a cavity, which have a positive volume with the apex; nodes and tets
# of a ring; new tets and their qualities; open faces of a replacement (keys, links); tables and stack of
# Klincsek's search for the best triangulation of a ring; corners of a tet; a table of faces and their
# aspect ratios (`tet_ratio_sums`); counts of operations in the order of KINDS.
Scratch = namedtuple(
    "Scratch",
    "star faces ring ring_tets new new_quality keys links best split stack corners table ratios done",
)
# Most tets in a star (MAX_STAR) and in a ring (MAX_RING); larger ones are skipped, because the work of a
# ring grows with the cube of its size.
MAX_STAR = 256
# Columns of a table of faces. Eight more than needed, because rows of a power of two long would share few
# lines of the processor's cache.
ROOM = MAX_STAR + 8
MAX_RING = 8
# Names of the counted operations.
KINDS = ("moves", "edges_removed", "faces_removed", "contractions", "insertions")

EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
# The other two corners for each edge, so that (edge, other two) is an even permutation.
OPPOSITE = np.array([[2, 3], [3, 1], [1, 2], [0, 3], [2, 0], [0, 1]])
# The face opposite each corner, so that the tet (face, corner) has a positive volume.
FACES = np.array([[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]])


def new_scratch() -> Scratch:
    """Return work arrays for passes over a mesh, as one struct that kernels get by reference."""
    arrays = Scratch(
        np.empty(MAX_STAR, np.int64),
        np.empty((MAX_STAR, 3), np.int64),
        np.empty(MAX_RING + 2, np.int64),
        np.empty(MAX_RING + 2, np.int64),
        np.empty((MAX_STAR, 4), np.int64),
        np.empty(MAX_STAR),
        np.empty((4 * MAX_STAR, 3), np.int64),
        np.empty((4 * MAX_STAR, 2), np.int64),
        np.empty((MAX_RING, MAX_RING)),
        np.empty((MAX_RING, MAX_RING), np.int64),
        np.empty((4 * MAX_RING, 2), np.int64),
        np.empty(4, np.int64),
        np.empty((TABLE_ROWS, ROOM)),
        np.empty(MAX_STAR),
        np.zeros(len(KINDS), np.int64),
    )
    scratch: Scratch = by_reference(arrays)
    return scratch


@lean_kernel
def face_key(tets, t, k):
    """Return lowest corner, highest corner and sum of corners of the face opposite corner k of tet t."""
    a, b, c = tets[t, (k + 1) & 3], tets[t, (k + 2) & 3], tets[t, (k + 3) & 3]
    return min(a, b, c), max(a, b, c), a + b + c


@kernel
def link_tets(tets, n_tets, n_points, neighbours, tet_of):
    """Fill `neighbours` and `tet_of`, a tet of each point, for the first n_tets tets.

    neighbours: -1 where no tet is beyond a face. No face is marked as a surface facet (-2 - u) yet.
    """
    head = np.full(n_points, -1, np.int64)
    following = np.full(4 * n_tets, -1, np.int64)
    for t in range(n_tets):
        for k in range(4):
            tet_of[tets[t, k]] = t
            low, high, total = face_key(tets, t, k)
            before, waiting = -1, head[low]
            neighbours[t, k] = -1
            while waiting >= 0:
                u, j = waiting >> 2, waiting & 3
                _, other_high, other_total = face_key(tets, u, j)
                if other_high == high and other_total == total:
                    neighbours[t, k] = u
                    neighbours[u, j] = t
                    if before < 0:
                        head[low] = following[waiting]
                    else:
                        following[before] = following[waiting]
                    break
                before, waiting = waiting, following[waiting]
            if neighbours[t, k] < 0:
                following[4 * t + k] = head[low]
                head[low] = 4 * t + k


@lean_kernel
def facet_at(tets, t, k, facets):
    """Return the row in `facets` of the face opposite corner k of tet t, -1 if there is none.

    facets (f, 3): sorted triples in lexicographic order.
    """
    low, high, total = face_key(tets, t, k)
    middle = total - low - high
    first, last = 0, len(facets)
    while first < last:
        half = (first + last) // 2
        a, b, c = facets[half, 0], facets[half, 1], facets[half, 2]
        if a < low or (a == low and (b < middle or (b == middle and c < high))):
            first = half + 1
        else:
            last = half
    if first == len(facets):
        return -1
    a, b, c = facets[first, 0], facets[first, 1], facets[first, 2]
    return first if a == low and b == middle and c == high else -1


@lean_kernel
def block_facets(tets, n_tets, neighbours, blocked):
    """Change the neighbour u across a facet to -2 - u, so that no operation crosses the facet.

    blocked (k, 3): the facets, as sorted triples in lexicographic order.
    """
    for t in range(n_tets):
        for k in range(4):
            if facet_at(tets, t, k, blocked) >= 0:
                neighbours[t, k] = min(-1, -2 - neighbours[t, k])


@lean_kernel
def node_across(state, t, k):
    """Return the fourth node of the tet across the face opposite corner k of tet t.

    It is -1 if no tet is there, or if the face is a surface or crack facet.
    """
    tets, u = state.tets, state.neighbours[t, k]
    if u < 0:
        return -1
    for j in range(4):
        node = tets[u, j]
        if node != tets[t, 0] and node != tets[t, 1] and node != tets[t, 2] and node != tets[t, 3]:
            return node
    return -1


@lean_kernel
def find_star(state, v, star):
    """Write the tets incident to v to `star`; return their number, -1 if too many.

    Tets are found over common faces, also over surface and crack facets, from state.tet_of[v] on.
    """
    tets, neighbours, mark = state.tets, state.neighbours, state.mark
    state.counts[STAMP] += 1
    stamp = state.counts[STAMP]
    star[0] = state.tet_of[v]
    mark[star[0]] = stamp
    count, done = 1, 0
    while done < count:
        t = star[done]
        done += 1
        for k in range(4):
            u = max(neighbours[t, k], -2 - neighbours[t, k])
            if tets[t, k] != v and u >= 0 and mark[u] != stamp:
                if count == len(star):
                    return -1
                mark[u] = stamp
                star[count] = u
                count += 1
    return count


@lean_kernel
def star_faces(tets, star, count, v, faces):
    """Write to `faces` the faces opposite v of the tets star[:count], each of positive volume with v."""
    for i in range(count):
        t = star[i]
        for k in range(4):
            if tets[t, k] == v:
                for j in range(3):
                    faces[i, j] = tets[t, FACES[k, j]]


@lean_kernel
def star_of(state, v, work):
    """Write v's incident tets to work.star and their faces opposite v to work.faces; return their number.

    The number is 0 if there are too many.
    """
    count = find_star(state, v, work.star)
    star_faces(state.tets, work.star, count, v, work.faces)
    return max(count, 0)


@lean_kernel
def list_stars(tets, n_tets, frozen, first, corners):
    """List the corners of live tets at each point that is not frozen; changes of topology outdate the list.

    The corners at point v are corners[first[v]:first[v + 1]], ascending; corner c is corner c % 4 of tet
    c // 4. first (n + 1,); `corners` must be long enough for all (not checked).
    """
    first[:] = 0
    for t in range(n_tets):
        for k in range(4):
            if tets[t, 0] >= 0 and not frozen[tets[t, k]]:
                first[tets[t, k]] += 1
    for v in range(1, len(first)):
        first[v] += first[v - 1]
    for t in range(n_tets - 1, -1, -1):
        for k in range(4):
            v = tets[t, k]
            if tets[t, 0] >= 0 and not frozen[v]:
                first[v] -= 1
                corners[first[v]] = 4 * t + k


@lean_kernel
def listed_star(tets, stars, v, work):
    """Write v's incident tets to work.star and their faces opposite v to work.faces; return their number.

    The number is 0 if there are too many. stars: the lists `first` and `corners` of `list_stars`.
    """
    first, corners = stars
    start, count = first[v], first[v + 1] - first[v]
    if count > len(work.star):
        return 0
    for i in range(count):
        t, k = corners[start + i] >> 2, corners[start + i] & 3
        work.star[i] = t
        for j in range(3):
            work.faces[i, j] = tets[t, FACES[k, j]]
    return count


@lean_kernel
def hold_pinched(state, valence, work):
    """Freeze surface points whose incident tets are not connected over faces, or are over MAX_STAR.

    valence (s,): number of tets incident to each of the first s points.
    """
    for v in range(len(valence)):
        if not state.frozen[v] and find_star(state, v, work.star) != valence[v]:
            state.frozen[v] = True


@lean_kernel
def find_ring(state, t, edge, ring, ring_tets):
    """Write the nodes and tets around an edge of tet t to `ring` and `ring_tets`; return their number.

    The number is 0 at a boundary or facet, or if there are more than MAX_RING. With a, b the edge's ends,
    the tets (a, b, ring[i], ring[i + 1]) have positive volumes, cyclically.
    """
    tets, neighbours = state.tets, state.neighbours
    a, b = tets[t, EDGES[edge, 0]], tets[t, EDGES[edge, 1]]
    ring[0], ring[1] = tets[t, OPPOSITE[edge, 0]], tets[t, OPPOSITE[edge, 1]]
    ring_tets[0] = t
    count, current, behind = 1, t, OPPOSITE[edge, 0]
    last = ring[1]
    while True:
        u = neighbours[current, behind]
        if u == t:
            return count
        if u < 0 or count == MAX_RING:
            return 0
        newest = -1
        for k in range(4):
            node = tets[u, k]
            if node == last:
                behind = k
            elif node != a and node != b:
                newest = node
        ring_tets[count] = u
        count += 1
        ring[count] = newest
        last, current = newest, u


@lean_kernel
def _open_outer_faces(state, old, n_old, keys, links):
    """Write the key and the link of each outer face of the cavity old[:n_old]; return their number.

    A key, corners and their sum, identifies a face (`face_key`). A link is the tet beyond, coded as in
    state.neighbours, and the corner of that tet opposite the face.
    """
    tets, neighbours, mark = state.tets, state.neighbours, state.mark
    state.counts[STAMP] += 1
    stamp = state.counts[STAMP]
    for i in range(n_old):
        mark[old[i]] = stamp
    count = 0
    for i in range(n_old):
        t = old[i]
        for k in range(4):
            u = neighbours[t, k]
            if u >= 0 and mark[u] == stamp:
                continue
            low, high, total = face_key(tets, t, k)
            keys[count, 0], keys[count, 1], keys[count, 2] = low, high, total
            links[count, 0], links[count, 1] = u, -1
            if u != -1:
                back, there = (t, u) if u >= 0 else (-2 - t, -2 - u)
                for j in range(4):
                    if neighbours[there, j] == back and face_key(tets, there, j) == (low, high, total):
                        links[count, 1] = j
            count += 1
    return count


@lean_kernel
def _close_face(state, t, k, keys, links, count):
    """Link the face opposite corner k of t to the equal open face, or add it to the open faces.

    Return the number of open faces.
    """
    low, high, total = face_key(state.tets, t, k)
    for f in range(count):
        if keys[f, 0] == low and keys[f, 1] == high and keys[f, 2] == total:
            u, j = links[f, 0], links[f, 1]
            state.neighbours[t, k] = u
            if u >= 0:
                state.neighbours[u, j] = t
            elif u < -1:
                state.neighbours[-2 - u, j] = -2 - t
            count -= 1
            for i in range(3):
                keys[f, i] = keys[count, i]
            links[f, 0], links[f, 1] = links[count, 0], links[count, 1]
            return count
    keys[count, 0], keys[count, 1], keys[count, 2] = low, high, total
    links[count, 0], links[count, 1] = t, k
    return count + 1


@lean_kernel
def replace_cavity(state, old, n_old, n_new, work):
    """Replace the tets old[:n_old] by work.new[:n_new], which must have the same outer faces.

    Not checked: the new tets, and that the arrays have room (`has_room`). The new tets get the grain of the
    first old tet.
    """
    tets, counts = state.tets, state.counts
    count = _open_outer_faces(state, old, n_old, work.keys, work.links)
    label = state.label[old[0]]
    for i in range(n_old):
        tets[old[i], 0] = -1
    for i in range(n_new):
        if i < n_old:
            t = old[i]
        elif counts[FREE] > 0:
            counts[FREE] -= 1
            t = state.free[counts[FREE]]
        else:
            t = counts[TETS]
            counts[TETS] += 1
        for k in range(4):
            tets[t, k] = work.new[i, k]
            state.tet_of[work.new[i, k]] = t
        state.quality[t] = work.new_quality[i]
        state.mark[t], state.label[t] = 0, label
        for k in range(4):
            count = _close_face(state, t, k, work.keys, work.links, count)
    for i in range(n_new, n_old):
        state.free[counts[FREE]] = old[i]
        counts[FREE] += 1


@lean_kernel
def has_room(state):
    """Return whether the arrays have room for one more operation: MAX_STAR new tets and a new point."""
    return state.counts[TETS] + MAX_STAR < len(state.tets) and state.counts[POINTS] + 1 < len(state.points)


@lean_kernel
def worst_of(quality, tets, count):
    """Return the lowest quality of the tets tets[:count], ids into `quality` (m,)."""
    worst = 1e300
    for i in range(count):
        worst = min(worst, quality[tets[i]])
    return worst
