"""Test whether two triangles, which may share vertices, intersect."""

import numpy as np

from craftmesh.jit import lean_kernel

# A triangle's size is the longer of the two edges at its first corner. Distance from a plane or line, in
# sizes of the larger triangle, below which a point is on it.
CONTACT = 1e-9
# Sine of the angle between two facets of one edge below which they are folded onto each other.
FOLD = 1e-6
# Height of a triangle, in its sizes, below which it has no usable normal.
FLAT = 1e-13


@lean_kernel
def _between(points, a, b):
    return (points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2])


@lean_kernel
def _dot(u, v):
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@lean_kernel
def _cross(u, v):
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


@lean_kernel
def _normal(points, a, b, c):
    return _cross(_between(points, a, b), _between(points, a, c))


@lean_kernel
def _squared_size(points, a, b, c):
    u, v = _between(points, a, b), _between(points, a, c)
    return max(_dot(u, u), _dot(v, v))


@lean_kernel
def _height(points, origin, normal, length, contact, x):
    """Return the signed distance of point x from a plane, set to 0 within `contact`."""
    if length == 0.0:
        return 0.0
    distance = _dot(normal, _between(points, origin, x)) / length
    return 0.0 if abs(distance) <= contact else distance


@lean_kernel
def _clear(size, normal):
    """Return the square of (height times normal's length) above which a point is clearly out of contact.

    The height is over the triangle's plane. The result is inf where the triangle with this normal may be
    flat; size: as from `_squared_size`.
    """
    square = _dot(normal, normal)
    if square <= (2.0 * FLAT * size) ** 2:
        return np.inf
    return 4.0 * CONTACT * CONTACT * size * square


@lean_kernel
def _dominant_axes(normal):
    """Return the two axes of the coordinate plane that a triangle with this normal is most parallel to."""
    x, y, z = abs(normal[0]), abs(normal[1]), abs(normal[2])
    if x >= y and x >= z:
        return 1, 2
    if y >= z:
        return 2, 0
    return 0, 1


@lean_kernel
def _cross_2d(points, o, a, b, i, j):
    return (points[a, i] - points[o, i]) * (points[b, j] - points[o, j]) - (points[a, j] - points[o, j]) * (
        points[b, i] - points[o, i]
    )


@lean_kernel
def _edges_separate(points, a0, a1, a2, b0, b1, b2, i, j, contact):
    """Return whether an edge line of triangle a has all of triangle b, in one plane, strictly outside.

    i, j: axes of the projection; contact: distance up to which points are on the line.
    """
    turn = 1.0 if _cross_2d(points, a0, a1, a2, i, j) > 0.0 else -1.0
    for p, q in ((a0, a1), (a1, a2), (a2, a0)):
        length = np.hypot(points[q, i] - points[p, i], points[q, j] - points[p, j])
        nearest = max(
            turn * _cross_2d(points, p, q, b0, i, j),
            turn * _cross_2d(points, p, q, b1, i, j),
            turn * _cross_2d(points, p, q, b2, i, j),
        )
        if nearest < -contact * length:
            return True
    return False


@lean_kernel
def _in_sector(points, s, p, q, x, i, j):
    """Return whether the ray from s to x lies in the closed angle p-s-q of a coplanar triangle."""
    turn = 1.0 if _cross_2d(points, s, p, q, i, j) > 0.0 else -1.0
    lp = np.hypot(points[p, i] - points[s, i], points[p, j] - points[s, j])
    lq = np.hypot(points[q, i] - points[s, i], points[q, j] - points[s, j])
    lx = np.hypot(points[x, i] - points[s, i], points[x, j] - points[s, j])
    return (
        turn * _cross_2d(points, s, p, x, i, j) >= -CONTACT * lp * lx
        and turn * _cross_2d(points, s, x, q, i, j) >= -CONTACT * lq * lx
    )


@lean_kernel
def _edge_hits(points, p, q, hp, hq, a, b, c, i, j):
    """Return whether edge p-q, at heights hp and hq over the plane of a-b-c, meets the closed triangle."""
    if (hp == 0.0 and hq == 0.0) or hp * hq > 0.0:
        return False
    s = hp / (hp - hq)
    xi = points[p, i] + s * (points[q, i] - points[p, i]) - points[a, i]
    xj = points[p, j] + s * (points[q, j] - points[p, j]) - points[a, j]
    ui, uj = points[b, i] - points[a, i], points[b, j] - points[a, j]
    vi, vj = points[c, i] - points[a, i], points[c, j] - points[a, j]
    area = ui * vj - uj * vi
    if area == 0.0:
        return False
    u = (xi * vj - xj * vi) / area
    v = (ui * xj - uj * xi) / area
    return u >= -CONTACT and v >= -CONTACT and u + v <= 1.0 + CONTACT


@lean_kernel
def _folded(points, a, b, c, d):
    """Return whether triangles a-b-c and a-b-d lie on each other, or one of them is flat."""
    edge = _between(points, a, b)
    n, m = _cross(edge, _between(points, a, c)), _cross(edge, _between(points, a, d))
    square, along = _dot(n, n) * _dot(m, m), _dot(n, m)
    if square == 0.0:
        return True
    if along <= 0.0:
        return False
    length = np.sqrt(square)
    turn = _cross(n, m)
    return np.sqrt(_dot(turn, turn)) <= FOLD * length


@lean_kernel
def _meet_beyond_vertex(points, s, p, q, r, t):
    """Return whether triangles s-p-q and s-r-t meet in more than their common vertex s."""
    m = _normal(points, s, r, t)
    size = max(_squared_size(points, s, p, q), _squared_size(points, s, r, t))
    over_p, over_q = _dot(m, _between(points, s, p)), _dot(m, _between(points, s, q))
    if over_p * over_q > 0.0 and min(over_p * over_p, over_q * over_q) > _clear(size, m):
        return False  # the usual case, without a square root
    n = _normal(points, s, p, q)
    ln, lm = np.sqrt(_dot(n, n)), np.sqrt(_dot(m, m))
    contact = CONTACT * np.sqrt(size)
    flat = FLAT * size
    if ln <= flat and lm <= flat:
        return False
    i, j = _dominant_axes(m)
    k, l = _dominant_axes(n)
    if lm > flat:
        hp, hq = _height(points, s, m, lm, contact, p), _height(points, s, m, lm, contact, q)
        if hp * hq > 0.0:
            return False
        if hp == 0.0 and hq == 0.0:
            return ln > flat and _sectors_meet(points, s, p, q, r, t, i, j)
        if _edge_hits(points, p, q, hp, hq, s, r, t, i, j):
            return True
    if ln > flat:
        hr, ht = _height(points, s, n, ln, contact, r), _height(points, s, n, ln, contact, t)
        if hr == 0.0 and ht == 0.0:
            return lm > flat and _sectors_meet(points, s, p, q, r, t, k, l)
        return _edge_hits(points, r, t, hr, ht, s, p, q, k, l)
    return False


@lean_kernel
def _sectors_meet(points, s, p, q, r, t, i, j):
    """Return whether the angles p-s-q and r-s-t of coplanar triangles overlap or touch."""
    return (
        _in_sector(points, s, p, q, r, i, j)
        or _in_sector(points, s, p, q, t, i, j)
        or _in_sector(points, s, r, t, p, i, j)
        or _in_sector(points, s, r, t, q, i, j)
    )


@lean_kernel
def _disjoint_triangles_meet(points, a0, a1, a2, b0, b1, b2):
    """Return whether two triangles without a common vertex touch, cross or overlap."""
    n = _normal(points, a0, a1, a2)
    size = max(_squared_size(points, a0, a1, a2), _squared_size(points, b0, b1, b2))
    first = _dot(n, _between(points, a0, b0))
    second = _dot(n, _between(points, a0, b1))
    third = _dot(n, _between(points, a0, b2))
    least = min(first * first, second * second, third * third)
    if first * second > 0.0 and first * third > 0.0 and least > _clear(size, n):
        return False  # the usual case, without a square root
    m = _normal(points, b0, b1, b2)
    ln, lm = np.sqrt(_dot(n, n)), np.sqrt(_dot(m, m))
    contact = CONTACT * np.sqrt(size)
    has_n, has_m = ln > FLAT * size, lm > FLAT * size
    ha0 = ha1 = ha2 = hb0 = hb1 = hb2 = 0.0
    if has_n:
        hb0 = _height(points, a0, n, ln, contact, b0)
        hb1 = _height(points, a0, n, ln, contact, b1)
        hb2 = _height(points, a0, n, ln, contact, b2)
        if (hb0 > 0.0 and hb1 > 0.0 and hb2 > 0.0) or (hb0 < 0.0 and hb1 < 0.0 and hb2 < 0.0):
            return False
    if has_m:
        ha0 = _height(points, b0, m, lm, contact, a0)
        ha1 = _height(points, b0, m, lm, contact, a1)
        ha2 = _height(points, b0, m, lm, contact, a2)
        if (ha0 > 0.0 and ha1 > 0.0 and ha2 > 0.0) or (ha0 < 0.0 and ha1 < 0.0 and ha2 < 0.0):
            return False
    i, j = _dominant_axes(m)
    k, l = _dominant_axes(n)
    if has_n and has_m and ((ha0 == ha1 == ha2 == 0.0) or (hb0 == hb1 == hb2 == 0.0)):
        if lm < ln:
            i, j = k, l
        return not (
            _edges_separate(points, a0, a1, a2, b0, b1, b2, i, j, contact)
            or _edges_separate(points, b0, b1, b2, a0, a1, a2, i, j, contact)
        )
    if has_m and (
        _edge_hits(points, a0, a1, ha0, ha1, b0, b1, b2, i, j)
        or _edge_hits(points, a1, a2, ha1, ha2, b0, b1, b2, i, j)
        or _edge_hits(points, a2, a0, ha2, ha0, b0, b1, b2, i, j)
    ):
        return True
    return has_n and (
        _edge_hits(points, b0, b1, hb0, hb1, a0, a1, a2, k, l)
        or _edge_hits(points, b1, b2, hb1, hb2, a0, a1, a2, k, l)
        or _edge_hits(points, b2, b0, hb2, hb0, a0, a1, a2, k, l)
    )


@lean_kernel
def triangles_intersect(points, a0, a1, a2, b0, b1, b2):
    """Return whether two triangles, given by ids, meet in more than the vertices that they share.

    Touching counts as meeting. Triangles with three common ids meet; with two, if they are folded onto each
    other; with one, if an opposite edge meets the other triangle or, in one plane, their angles at the
    common vertex overlap; with none, if they touch, cross or overlap in one plane.
    """
    shared = 0
    a_first = a_second = b_first = b_second = 0
    a, b = (a0, a1, a2), (b0, b1, b2)
    for i in range(3):
        for j in range(3):
            if a[i] == b[j]:
                shared += 1
                if shared == 1:
                    a_first, b_first = i, j
                else:
                    a_second, b_second = i, j
    if shared == 0:
        return _disjoint_triangles_meet(points, a0, a1, a2, b0, b1, b2)
    if shared == 1:
        p, q = a[(a_first + 1) % 3], a[(a_first + 2) % 3]
        r, t = b[(b_first + 1) % 3], b[(b_first + 2) % 3]
        return _meet_beyond_vertex(points, a[a_first], p, q, r, t)
    if shared == 2:
        p, q = a[3 - a_first - a_second], b[3 - b_first - b_second]
        return _folded(points, a[a_first], a[a_second], p, q)
    return True
