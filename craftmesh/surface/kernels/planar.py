"""Kernels for plane triangulations with fixed edges: flips, point insertion, edge recovery.

Edge i of a triangle runs from its corner i to its corner i + 1. A point is a row of `uv`.
"""

from typing import NamedTuple

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.rounding import EXACT, ROUNDING

DONE, BLOCKED = 0, 1  # results of insert_point
COCIRCULAR = 1e-10  # sine of the angle by which a new diagonal must be better, which prevents endless flips


class Planar(NamedTuple):
    """A plane triangulation; every array except `used` has spare rows.

    uv (n, 2): points; corners (t, 3) int64, counter-clockwise; across (t, 3) int64: triangle on the other
    side of each edge, or -1; fixed (t, 3): mask of edges that no kernel flips, the same from both sides;
    used (2,) int64: numbers of points and triangles in use.
    """

    uv: np.ndarray
    corners: np.ndarray
    across: np.ndarray
    fixed: np.ndarray
    used: np.ndarray

    @property
    def triangles(self) -> np.ndarray:
        """(t, 3) corners of the triangles in use."""
        return self.corners[: self.used[1]]


class Candidates(NamedTuple):
    """Points that may be inserted: uv (k, 2), and the smallest distances that each has to keep.

    start (k,): triangle from which a candidate can be reached without crossing a fixed edge; spacing (k,):
    from the corners of the containing triangle and its neighbours; clearance (k,): from fixed edges of that
    triangle.
    """

    uv: np.ndarray
    start: np.ndarray
    spacing: np.ndarray
    clearance: np.ndarray


@lean_kernel
def turn(uv, a, b, c):
    """Return twice the signed area of triangle a, b, c."""
    return (uv[b, 0] - uv[a, 0]) * (uv[c, 1] - uv[a, 1]) - (uv[b, 1] - uv[a, 1]) * (uv[c, 0] - uv[a, 0])


@lean_kernel
def squared_distance(uv, a, b):
    """Return the squared distance between points a and b."""
    return (uv[a, 0] - uv[b, 0]) ** 2 + (uv[a, 1] - uv[b, 1]) ** 2


@lean_kernel
def _edge_from(mesh, t, a):
    """Return the edge of triangle t that starts at point a; -1 if a is not a corner of t."""
    for i in range(3):
        if mesh.corners[t, i] == a:
            return i
    return -1


@lean_kernel
def _edges(mesh, t, i):
    """Return the three edges of triangle t from edge i on, each as (triangle across, is fixed)."""
    j, k = (i + 1) % 3, (i + 2) % 3
    return (
        (mesh.across[t, i], mesh.fixed[t, i]),
        (mesh.across[t, j], mesh.fixed[t, j]),
        (mesh.across[t, k], mesh.fixed[t, k]),
    )


@lean_kernel
def _free(u):
    """Return an edge that is not fixed, with triangle u across, as (triangle across, is fixed)."""
    return u, bool(0)  # False is a literal type in numba; each function that gets it would compile again


@lean_kernel
def _put(mesh, t, corners, first, second, third):
    """Set the corners and edges (across, fixed) of triangle t; the triangles across are not updated."""
    for i in range(3):
        mesh.corners[t, i] = corners[i]
    mesh.across[t, 0], mesh.fixed[t, 0] = first
    mesh.across[t, 1], mesh.fixed[t, 1] = second
    mesh.across[t, 2], mesh.fixed[t, 2] = third


@lean_kernel
def _tell_neighbours(mesh, t):
    """Set t as the triangle across in all neighbours of t."""
    for i in range(3):
        u = mesh.across[t, i]
        if u >= 0:
            mesh.across[u, _edge_from(mesh, u, mesh.corners[t, (i + 1) % 3])] = t


@lean_kernel
def _pair(mesh, t, i):
    """Return, for the inner edge i of t: its ends a and b, apex c of t, neighbour u, apex d of u, and j.

    j is the same edge in u, where it runs from b to a.
    """
    a, b, c = mesh.corners[t, i], mesh.corners[t, (i + 1) % 3], mesh.corners[t, (i + 2) % 3]
    u = mesh.across[t, i]
    j = _edge_from(mesh, u, b)
    return a, b, c, u, mesh.corners[u, (j + 2) % 3], j


@kernel
def _prefers_flip(uv, a, b, c, d):
    """Return whether c-d is the better diagonal of triangles a-b-c and b-a-d by Delaunay's criterion.

    False if the two triangles do not form a convex quadrangle.
    """
    if turn(uv, c, d, b) <= 0.0 or turn(uv, d, c, a) <= 0.0:
        return False
    ca, cb = (uv[a] - uv[c]), (uv[b] - uv[c])
    da, db = (uv[a] - uv[d]), (uv[b] - uv[d])
    dot_c, dot_d = ca[0] * cb[0] + ca[1] * cb[1], da[0] * db[0] + da[1] * db[1]
    sin_c, sin_d = abs(ca[0] * cb[1] - ca[1] * cb[0]), abs(da[0] * db[1] - da[1] * db[0])
    scale = np.sqrt((dot_c**2 + sin_c**2) * (dot_d**2 + sin_d**2))
    return sin_c * dot_d + sin_d * dot_c < -COCIRCULAR * scale


@lean_kernel
def flip(mesh, t, i):
    """Replace the inner edge i of t by the other diagonal of its two triangles."""
    a, b, c, u, d, j = _pair(mesh, t, i)
    _, bc, ca = _edges(mesh, t, i)
    _, ad, db = _edges(mesh, u, j)
    _put(mesh, t, (a, d, c), ad, _free(u), ca)
    _put(mesh, u, (b, c, d), bc, _free(t), db)
    _tell_neighbours(mesh, t)
    _tell_neighbours(mesh, u)


@kernel
def _legalise(mesh, waiting):
    """Flip free edges of the triangles `waiting`, last first, until they are constrained Delaunay."""
    height = len(waiting)
    stack = np.concatenate((waiting, waiting))
    while height > 0:
        height -= 1
        t = stack[height]
        for i in range(3):
            if mesh.across[t, i] < 0 or mesh.fixed[t, i]:
                continue
            a, b, c, u, d, _ = _pair(mesh, t, i)
            if _prefers_flip(mesh.uv, a, b, c, d):
                flip(mesh, t, i)
                if height + 2 > len(stack):
                    stack = np.concatenate((stack, stack))
                stack[height], stack[height + 1] = t, u
                height += 2
                break


@kernel
def legalise_all(mesh):
    """Make the whole triangulation constrained Delaunay."""
    _legalise(mesh, np.arange(mesh.used[1] - 1, -1, -1))


@lean_kernel
def locate(mesh, start, point, through_fixed):
    """Walk from triangle `start` to the one that contains `point`; return -1 if the walk is stopped.

    The boundary, fixed edges unless through_fixed, and a walk in circles stop it. A point beyond an edge by
    at most EXACT of its length counts as inside.
    """
    t = start
    for _ in range(2 * len(mesh.corners) + 10):
        worst, exit_edge = 0.0, -1
        for i in range(3):
            a, b = mesh.corners[t, i], mesh.corners[t, (i + 1) % 3]
            doubled, square = turn(mesh.uv, a, b, point), squared_distance(mesh.uv, a, b)
            if doubled < -EXACT * square and doubled < worst * np.sqrt(square):
                worst, exit_edge = doubled / np.sqrt(square), i
        if exit_edge < 0:
            return t
        if mesh.across[t, exit_edge] < 0 or (mesh.fixed[t, exit_edge] and not through_fixed):
            return -1
        t = mesh.across[t, exit_edge]
    return -1


@lean_kernel
def _new_triangles(mesh):
    """Return the ids of two spare triangles and mark them as used."""
    mesh.used[1] += 2
    return mesh.used[1] - 2, mesh.used[1] - 1


@lean_kernel
def _split_triangle(mesh, t, point):
    """Split triangle t into three at `point`, inside it; return the ids of the two new ones."""
    a, b, c = mesh.corners[t]
    ab, bc, ca = _edges(mesh, t, 0)
    u, w = _new_triangles(mesh)
    _put(mesh, t, (a, b, point), ab, _free(u), _free(w))
    _put(mesh, u, (b, c, point), bc, _free(w), _free(t))
    _put(mesh, w, (c, a, point), ca, _free(t), _free(u))
    _tell_neighbours(mesh, u)
    _tell_neighbours(mesh, w)
    return u, w


@lean_kernel
def split_inner_edge(mesh, t, i, point):
    """Split the inner edge i of t at `point`: two triangles become four, no edge is flipped.

    The halves are fixed if the edge was. Return the ids of the two new triangles.
    """
    a, b, c, u, d, j = _pair(mesh, t, i)
    _, bc, ca = _edges(mesh, t, i)
    _, ad, db = _edges(mesh, u, j)
    is_fixed = mesh.fixed[t, i]
    v, w = _new_triangles(mesh)
    _put(mesh, t, (a, point, c), (w, is_fixed), _free(v), ca)
    _put(mesh, v, (point, b, c), (u, is_fixed), bc, _free(t))
    _put(mesh, u, (b, point, d), (v, is_fixed), _free(w), db)
    _put(mesh, w, (point, a, d), (t, is_fixed), ad, _free(u))
    _tell_neighbours(mesh, v)
    _tell_neighbours(mesh, w)
    return v, w


@lean_kernel
def _meets_on_wall(mesh, t, i, walls, corners):
    """Return whether one wall contains the first `corners` (2 or 3) corners of t, counted from edge i on.

    A wall is the front, a grain boundary, a void or a box plane. walls (n, w): mask of the points on each.
    """
    for w in range(walls.shape[1]):
        held = True
        for k in range(corners):
            point = mesh.corners[t, (i + k) % 3]
            held = held and point < len(walls) and walls[point, w]
        if held:
            return True
    return False


@lean_kernel
def split_within_walls(mesh, walls, corners):
    """Split edges that are not fixed and join two points of one wall at their midpoints; return how many.

    A wall is the front, a grain boundary, a void or a box plane. walls (n, w): mask of the first n points
    on each. corners: 2, or 3 to split only edges of
    triangles with all corners on one wall. There must be spare rows for the midpoint of every edge.
    """
    first = mesh.used[0]
    t = 0
    while t < mesh.used[1]:
        for i in range(3):
            if not mesh.fixed[t, i] and _meets_on_wall(mesh, t, i, walls, corners):
                a, b, point = mesh.corners[t, i], mesh.corners[t, (i + 1) % 3], mesh.used[0]
                for k in range(2):
                    mesh.uv[point, k] = (mesh.uv[a, k] + mesh.uv[b, k]) / 2
                mesh.used[0] += 1
                split_inner_edge(mesh, t, i, point)
        t += 1
    return mesh.used[0] - first


@kernel
def insert_point(mesh, t, point):
    """Insert `point`, inside triangle t, and flip edges around it to restore Delaunay's criterion.

    Return DONE, or BLOCKED if the point is on a fixed or outer edge.

    Two spare triangles are required.
    """
    changed = np.empty(4, np.int64)
    for i in range(3):
        a, b = mesh.corners[t, i], mesh.corners[t, (i + 1) % 3]
        if turn(mesh.uv, a, b, point) <= ROUNDING * squared_distance(mesh.uv, a, b):
            u = mesh.across[t, i]
            if mesh.fixed[t, i] or u < 0:
                return BLOCKED
            v, w = split_inner_edge(mesh, t, i, point)
            changed[0], changed[1], changed[2], changed[3] = t, u, v, w
            _legalise(mesh, changed)
            return DONE
    u, w = _split_triangle(mesh, t, point)
    changed[0], changed[1], changed[2] = t, u, w
    _legalise(mesh, changed[:3])
    return DONE


@kernel
def insert_spaced(mesh, candidates, frozen):
    """Insert the candidates that keep their distances, in order; return how many were inserted.

    frozen (t,): mask of triangles into which nothing is inserted. There must be spare rows for all
    candidates.
    """
    inserted = 0
    for k in range(len(candidates.uv)):
        point = mesh.used[0]
        mesh.uv[point] = candidates.uv[k]
        t = locate(mesh, candidates.start[k], point, False)
        if t < 0 or frozen[t]:
            continue
        if not _is_clear(mesh, t, point, candidates.spacing[k], candidates.clearance[k]):
            continue
        if insert_point(mesh, t, point) == DONE:
            mesh.used[0] += 1
            inserted += 1
    return inserted


@lean_kernel
def _is_clear(mesh, t, point, spacing, clearance):
    """Return whether `point` in triangle t keeps its distances.

    These are `spacing` from the corners of t and of its neighbours, and `clearance` from the fixed edges of
    t.
    """
    for i in range(3):
        a, b = mesh.corners[t, i], mesh.corners[t, (i + 1) % 3]
        if squared_distance(mesh.uv, a, point) < spacing * spacing:
            return False
        u = mesh.across[t, i]
        if mesh.fixed[t, i] or u < 0:
            if turn(mesh.uv, a, b, point) < clearance * np.sqrt(squared_distance(mesh.uv, a, b)):
                return False
            continue
        d = mesh.corners[u, (_edge_from(mesh, u, b) + 2) % 3]
        if squared_distance(mesh.uv, d, point) < spacing * spacing:
            return False
    return True


@lean_kernel
def recover_edge(mesh, a, b):
    """Make the segment a-b an edge by flipping free edges that cross it; return False if impossible.

    Each pass visits all triangles, and an edge without a convex pair waits for the next pass: the cost is
    triangles times passes. It is used before the refinement, for the few segments that bound no polygon.
    """
    for _ in range(10 * mesh.used[1] + 100):
        if _has_edge(mesh, a, b):
            return True
        if not _flip_crossing(mesh, a, b):
            return False
    return False


@lean_kernel
def _has_edge(mesh, a, b):
    """Return whether a triangle has the edge a-b."""
    for t in range(mesh.used[1]):
        if _edge_from(mesh, t, a) >= 0 and _edge_from(mesh, t, b) >= 0:
            return True
    return False


@lean_kernel
def _flip_crossing(mesh, a, b):
    """Flip free edges that cross the segment a-b if triangles stay valid; return whether any flipped."""
    flipped = False
    for t in range(mesh.used[1]):
        for i in range(3):
            if mesh.across[t, i] < t or mesh.fixed[t, i]:
                continue
            p, q, r, _, s, _ = _pair(mesh, t, i)
            if not _crosses(mesh.uv, a, b, p, q):
                continue
            if turn(mesh.uv, r, s, q) <= 0.0 or turn(mesh.uv, s, r, p) <= 0.0:
                continue
            flip(mesh, t, i)
            flipped = True
    return flipped


@lean_kernel
def _crosses(uv, a, b, p, q):
    """Return whether segments a-b and p-q cross in their interiors; False if they share a point."""
    if a == p or a == q or b == p or b == q:
        return False
    return turn(uv, a, b, p) * turn(uv, a, b, q) < 0.0 and turn(uv, p, q, a) * turn(uv, p, q, b) < 0.0
