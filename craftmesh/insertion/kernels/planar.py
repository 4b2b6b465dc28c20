"""Kernels on planar triangulations with fixed edges: flips, insertion, recovery of edges.

A triangulation is corners (t, 3) int64 counter-clockwise, across (t, 3) int64 (the triangle across the
edge from corner i to i + 1, or -1) and fixed (t, 3) bool; all with spare rows, `used` = [points,
triangles].
"""

import numpy as np
from numba import njit

DONE, BLOCKED = 0, 1


@njit(cache=True)
def turn(uv, a, b, c):
    """Twice the signed area of a, b, c."""
    return (uv[b, 0] - uv[a, 0]) * (uv[c, 1] - uv[a, 1]) - (uv[b, 1] - uv[a, 1]) * (uv[c, 0] - uv[a, 0])


@njit(cache=True)
def square(uv, a, b):
    return (uv[a, 0] - uv[b, 0]) ** 2 + (uv[a, 1] - uv[b, 1]) ** 2


@njit(cache=True)
def _edge_from(corners, t, a):
    """The edge of triangle t that starts at point a."""
    for i in range(3):
        if corners[t, i] == a:
            return i
    return -1


@njit(cache=True)
def _place(corners, across, fixed, t, i, point, neighbour, is_fixed):
    """Set corner i of t and the edge that starts there; the neighbour's link is set back to t."""
    corners[t, i] = point
    across[t, i] = neighbour
    fixed[t, i] = is_fixed


@njit(cache=True)
def _link_back(corners, across, t):
    """Let the neighbours of t point to t."""
    for i in range(3):
        u = across[t, i]
        if u >= 0:
            across[u, _edge_from(corners, u, corners[t, (i + 1) % 3])] = t


@njit(cache=True)
def _prefers_flip(uv, a, b, c, d):
    """Whether edge a-b with c ahead and d behind it is better replaced by c-d (Delaunay, convex)."""
    if turn(uv, c, d, b) <= 0.0 or turn(uv, d, c, a) <= 0.0:
        return False
    ca, cb = (uv[a] - uv[c]), (uv[b] - uv[c])
    da, db = (uv[a] - uv[d]), (uv[b] - uv[d])
    dot_c, dot_d = ca[0] * cb[0] + ca[1] * cb[1], da[0] * db[0] + da[1] * db[1]
    sin_c, sin_d = abs(ca[0] * cb[1] - ca[1] * cb[0]), abs(da[0] * db[1] - da[1] * db[0])
    scale = np.sqrt((dot_c**2 + sin_c**2) * (dot_d**2 + sin_d**2))
    return sin_c * dot_d + sin_d * dot_c < -1e-10 * scale


@njit(cache=True)
def flip(corners, across, fixed, t, i):
    """Replace the edge i of t, shared with another triangle, by the other diagonal."""
    a, b, c = corners[t, i], corners[t, (i + 1) % 3], corners[t, (i + 2) % 3]
    u = across[t, i]
    j = _edge_from(corners, u, b)
    d = corners[u, (j + 2) % 3]
    bc, ca = (i + 1) % 3, (i + 2) % 3
    ad, db = (j + 1) % 3, (j + 2) % 3
    out_bc, out_ca, out_ad, out_db = across[t, bc], across[t, ca], across[u, ad], across[u, db]
    fix_bc, fix_ca, fix_ad, fix_db = fixed[t, bc], fixed[t, ca], fixed[u, ad], fixed[u, db]
    _place(corners, across, fixed, t, 0, a, out_ad, fix_ad)
    _place(corners, across, fixed, t, 1, d, u, False)
    _place(corners, across, fixed, t, 2, c, out_ca, fix_ca)
    _place(corners, across, fixed, u, 0, b, out_bc, fix_bc)
    _place(corners, across, fixed, u, 1, c, t, False)
    _place(corners, across, fixed, u, 2, d, out_db, fix_db)
    _link_back(corners, across, t)
    _link_back(corners, across, u)


@njit(cache=True)
def legalise(uv, corners, across, fixed, stack, height):
    """Flip free edges of the triangles on the stack until they are constrained Delaunay."""
    while height > 0:
        height -= 1
        t = stack[height]
        for i in range(3):
            u = across[t, i]
            if u < 0 or fixed[t, i]:
                continue
            a, b, c = corners[t, i], corners[t, (i + 1) % 3], corners[t, (i + 2) % 3]
            d = corners[u, (_edge_from(corners, u, b) + 2) % 3]
            if _prefers_flip(uv, a, b, c, d):
                flip(corners, across, fixed, t, i)
                if height + 2 <= len(stack):
                    stack[height], stack[height + 1] = t, u
                    height += 2
                break


@njit(cache=True)
def legalise_all(uv, corners, across, fixed, used):
    """Make the whole triangulation constrained Delaunay."""
    stack = np.empty(8 * len(corners) + 64, np.int64)
    for t in range(used[1]):
        stack[t] = used[1] - 1 - t
    legalise(uv, corners, across, fixed, stack, used[1])


@njit(cache=True)
def locate(uv, corners, across, fixed, start, point, through_fixed):
    """Walk from triangle `start` to the one that holds `point`; -1 where an edge stops it."""
    t = start
    for _ in range(2 * len(corners) + 10):
        worst, exit_edge = -1e-14, -1
        for i in range(3):
            a, b = corners[t, i], corners[t, (i + 1) % 3]
            side = (uv[b, 0] - uv[a, 0]) * (uv[point, 1] - uv[a, 1]) - (uv[b, 1] - uv[a, 1]) * (
                uv[point, 0] - uv[a, 0]
            )
            side /= np.sqrt(square(uv, a, b)) + 1e-300
            if side < worst:
                worst, exit_edge = side, i
        if exit_edge < 0:
            return t
        if across[t, exit_edge] < 0 or (fixed[t, exit_edge] and not through_fixed):
            return -1
        t = across[t, exit_edge]
    return -1


@njit(cache=True)
def _insert_in_triangle(corners, across, fixed, used, t, point):
    a, b, c = corners[t]
    ab, bc, ca = across[t]
    fix_ab, fix_bc, fix_ca = fixed[t]
    u, w = used[1], used[1] + 1
    used[1] += 2
    _place(corners, across, fixed, t, 0, a, ab, fix_ab)
    _place(corners, across, fixed, t, 1, b, u, False)
    _place(corners, across, fixed, t, 2, point, w, False)
    _place(corners, across, fixed, u, 0, b, bc, fix_bc)
    _place(corners, across, fixed, u, 1, c, w, False)
    _place(corners, across, fixed, u, 2, point, t, False)
    _place(corners, across, fixed, w, 0, c, ca, fix_ca)
    _place(corners, across, fixed, w, 1, a, t, False)
    _place(corners, across, fixed, w, 2, point, u, False)
    _link_back(corners, across, u)
    _link_back(corners, across, w)
    return u, w


@njit(cache=True)
def split_edge(corners, across, fixed, used, t, i, point):
    """Put `point` on the inner edge i of t: two triangles become four, no edge is flipped."""
    a, b, c = corners[t, i], corners[t, (i + 1) % 3], corners[t, (i + 2) % 3]
    u = across[t, i]
    j = _edge_from(corners, u, b)
    d = corners[u, (j + 2) % 3]
    bc, ca = across[t, (i + 1) % 3], across[t, (i + 2) % 3]
    ad, db = across[u, (j + 1) % 3], across[u, (j + 2) % 3]
    fix_bc, fix_ca = fixed[t, (i + 1) % 3], fixed[t, (i + 2) % 3]
    fix_ad, fix_db = fixed[u, (j + 1) % 3], fixed[u, (j + 2) % 3]
    edge_fixed = fixed[t, i]
    v, w = used[1], used[1] + 1
    used[1] += 2
    _place(corners, across, fixed, t, 0, a, w, edge_fixed)
    _place(corners, across, fixed, t, 1, point, v, False)
    _place(corners, across, fixed, t, 2, c, ca, fix_ca)
    _place(corners, across, fixed, v, 0, point, u, edge_fixed)
    _place(corners, across, fixed, v, 1, b, bc, fix_bc)
    _place(corners, across, fixed, v, 2, c, t, False)
    _place(corners, across, fixed, u, 0, b, v, edge_fixed)
    _place(corners, across, fixed, u, 1, point, w, False)
    _place(corners, across, fixed, u, 2, d, db, fix_db)
    _place(corners, across, fixed, w, 0, point, t, edge_fixed)
    _place(corners, across, fixed, w, 1, a, ad, fix_ad)
    _place(corners, across, fixed, w, 2, d, u, False)
    _link_back(corners, across, v)
    _link_back(corners, across, w)


@njit(cache=True)
def insert_point(uv, corners, across, fixed, used, t, point, stack):
    """Insert `point`, which lies in triangle t, and legalise around it; BLOCKED on a fixed or rim edge."""
    for i in range(3):
        a, b = corners[t, i], corners[t, (i + 1) % 3]
        length = square(uv, a, b)
        if turn(uv, a, b, point) <= 1e-9 * length:
            if fixed[t, i] or across[t, i] < 0:
                return BLOCKED
            u, rows = across[t, i], used[1]
            split_edge(corners, across, fixed, used, t, i, point)
            stack[0], stack[1], stack[2], stack[3] = t, u, rows, rows + 1
            legalise(uv, corners, across, fixed, stack, 4)
            return DONE
    u, w = _insert_in_triangle(corners, across, fixed, used, t, point)
    stack[0], stack[1], stack[2] = t, u, w
    legalise(uv, corners, across, fixed, stack, 3)
    return DONE


@njit(cache=True)
def insert_spaced(uv, corners, across, fixed, frozen, used, starts, candidates, spacing, clearance, stack):
    """Insert candidates (k, 2) that keep `spacing` from points and `clearance` from fixed edges.

    starts (k,): a triangle from which a candidate can be reached without crossing a fixed edge.
    Returns how many were inserted.
    """
    inserted = 0
    for k in range(len(candidates)):
        point = used[0]
        if point >= len(uv) or used[1] + 2 > len(corners):
            break
        uv[point] = candidates[k]
        t = locate(uv, corners, across, fixed, starts[k], point, False)
        if t < 0 or frozen[t]:
            continue
        if not _is_clear(uv, corners, across, fixed, t, point, spacing[k], clearance[k]):
            continue
        if insert_point(uv, corners, across, fixed, used, t, point, stack) == DONE:
            used[0] += 1
            inserted += 1
    return inserted


@njit(cache=True)
def _is_clear(uv, corners, across, fixed, t, point, spacing, clearance):
    for i in range(3):
        a, b = corners[t, i], corners[t, (i + 1) % 3]
        if square(uv, a, point) < spacing * spacing:
            return False
        u = across[t, i]
        if fixed[t, i] or u < 0:
            if turn(uv, a, b, point) < clearance * np.sqrt(square(uv, a, b)):
                return False
            continue
        d = corners[u, (_edge_from(corners, u, b) + 2) % 3]
        if square(uv, d, point) < spacing * spacing:
            return False
    return True


@njit(cache=True)
def recover_edge(uv, corners, across, fixed, used, a, b):
    """Make the segment a-b an edge by flipping the free edges that cross it; False where it cannot be."""
    for _ in range(10 * used[1] + 100):
        crossed = False
        for t in range(used[1]):
            i = _edge_from(corners, t, a)
            if i < 0:
                continue
            if corners[t, (i + 1) % 3] == b or corners[t, (i + 2) % 3] == b:
                return True
        for t in range(used[1]):
            for i in range(3):
                u = across[t, i]
                if u < t or fixed[t, i]:
                    continue
                p, q, r = corners[t, i], corners[t, (i + 1) % 3], corners[t, (i + 2) % 3]
                if not _crosses(uv, a, b, p, q):
                    continue
                s = corners[u, (_edge_from(corners, u, q) + 2) % 3]
                if turn(uv, r, s, q) <= 0.0 or turn(uv, s, r, p) <= 0.0:
                    continue
                flip(corners, across, fixed, t, i)
                crossed = True
        if not crossed:
            return False
    return False


@njit(cache=True)
def _crosses(uv, a, b, p, q):
    if a == p or a == q or b == p or b == q:
        return False
    return turn(uv, a, b, p) * turn(uv, a, b, q) < 0.0 and turn(uv, p, q, a) * turn(uv, p, q, b) < 0.0
