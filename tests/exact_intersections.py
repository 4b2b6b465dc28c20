"""Facets that meet in more than the corners and edges they share, decided in rational numbers."""

from fractions import Fraction

import numpy as np


def close_pairs(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the pairs (k, 2) of facets whose boxes along the axes meet."""
    corners = points[facets]
    low, high = corners.min(axis=1), corners.max(axis=1)
    order = np.argsort(low[:, 0], kind="stable")
    last = np.searchsorted(low[order, 0], high[order, 0], side="right")
    count = last - np.arange(len(order)) - 1
    first = np.repeat(np.arange(len(order)), count)
    second = first + 1 + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    i, j = order[first], order[second]
    meet = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
    return np.stack([i[meet], j[meet]], axis=1)


def intersections(points: np.ndarray, facets: np.ndarray) -> list[tuple[int, int]]:
    """Return the pairs of facets that meet in more than the corners and edges they share, exactly.

    Pairs that a plane parts by more than rounding errors are passed over; the rest is decided in
    rational numbers.
    """
    pairs = close_pairs(points, facets)
    undecided = pairs[~_parted(points, facets, pairs)]
    place = [[Fraction(float(x)) for x in point] for point in points]
    return [(int(i), int(j)) for i, j in undecided if _meet(place, facets[i].tolist(), facets[j].tolist())]


def _parted(points, facets, pairs) -> np.ndarray:
    """Return (k,) bool: pairs that a plane surely parts, the corners they share lying on it."""
    f, g = facets[pairs[:, 0]], facets[pairs[:, 1]]
    same = f[:, :, None] == g[:, None, :]
    shared_f, shared_g = same.any(axis=2), same.any(axis=1)
    joined = shared_f.any(axis=1)
    rows = np.arange(len(pairs))
    origin = points[f[rows, shared_f.argmax(axis=1)]]
    p, q = points[f] - origin[:, None], points[g] - origin[:, None]
    scale = np.maximum(np.abs(p).max(axis=(1, 2)), np.abs(q).max(axis=(1, 2)))
    p, q = p / scale[:, None, None], q / scale[:, None, None]
    parted, twins = np.zeros(len(pairs), bool), shared_f.all(axis=1)
    for number in range(17):
        left = np.flatnonzero(~parted)
        axis = _axis(number, p[left], q[left])
        length = np.linalg.norm(axis, axis=1)
        axis /= np.maximum(length, 1e-300)[:, None]
        x, y = (np.einsum("ijk,ik->ij", corners[left], axis) for corners in (p, q))
        on_f, on_g = shared_f[left], shared_g[left]
        sure = (length > 1e-6) & (np.where(on_f, np.abs(x), 0.0).max(axis=1) <= 1e-13)
        apart = np.maximum(y.min(axis=1) - x.max(axis=1), x.min(axis=1) - y.max(axis=1)) > 1e-9
        beside = _beside(x, y, on_f) | _beside(y, x, on_g)
        parted[left] = sure & np.where(joined[left], beside, apart)
    return parted & ~twins


def _axis(number: int, p, q) -> np.ndarray:
    """Return one of the normals of planes that may part triangles p and q (k, 3, 3)."""
    e, h = np.roll(p, -1, axis=1) - p, np.roll(q, -1, axis=1) - q
    if number >= 8:
        return np.cross(e[:, (number - 8) // 3], h[:, (number - 8) % 3])
    side = (e, h)[number % 2]
    normal = np.cross(side[:, 0], side[:, 1])
    return normal if number < 2 else np.cross(normal, side[:, number // 2 - 1])


def _beside(x, y, shared) -> np.ndarray:
    """Tell whether the corners of x that are not `shared` are all above 0 and none of y is, or below."""
    above = np.where(shared, np.inf, x).min(axis=1) > 1e-6
    below = np.where(shared, -np.inf, x).max(axis=1) < -1e-6
    return above & (y.max(axis=1) <= 1e-13) | below & (y.min(axis=1) >= -1e-13)


def _meet(place, f, g) -> bool:
    """Tell whether facets f and g meet beyond what they share; coordinates are rational."""
    shared = [v for v in f if v in g]
    p, q = [place[v] for v in f], [place[v] for v in g]
    if len(shared) == 3:
        return True
    if len(shared) == 2:
        a, b = (place[v] for v in shared)
        c = place[next(v for v in f if v not in shared)]
        d = place[next(v for v in g if v not in shared)]
        normal = _cross(_less(b, a), _less(c, a))
        if not any(normal):
            return True
        along = _cross(normal, _less(b, a))
        return _dot(normal, _less(d, a)) == 0 and _dot(along, _less(d, a)) > 0
    if len(shared) == 1:
        across_f = [place[v] for v in f if v not in shared]
        across_g = [place[v] for v in g if v not in shared]
        return _crosses(*across_f, q) or _crosses(*across_g, p)
    return any(_crosses(p[i], p[i - 1], q) or _crosses(q[i], q[i - 1], p) for i in range(3))


def _less(a, b):
    return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _crosses(a, b, triangle) -> bool:
    """Tell whether segment a-b meets the closed triangle."""
    normal = _cross(_less(triangle[1], triangle[0]), _less(triangle[2], triangle[0]))
    s, t = _dot(normal, _less(a, triangle[0])), _dot(normal, _less(b, triangle[0]))
    if s * t > 0:
        return False
    if s == 0 and t == 0:
        return _crosses_flat(a, b, triangle, normal)
    part = s / (s - t)
    x = [a[k] + part * (b[k] - a[k]) for k in range(3)]
    return _holds(x, triangle, normal)


def _holds(x, triangle, normal) -> bool:
    turns = [
        _dot(normal, _cross(_less(triangle[(i + 1) % 3], triangle[i]), _less(x, triangle[i])))
        for i in range(3)
    ]
    return min(turns) >= 0


def _crosses_flat(a, b, triangle, normal) -> bool:
    if not any(normal):
        return True
    if _holds(a, triangle, normal) or _holds(b, triangle, normal):
        return True
    axis = max(range(3), key=lambda k: abs(normal[k]))
    i, j = [k for k in range(3) if k != axis]

    def turn(p, q, r):
        return (q[i] - p[i]) * (r[j] - p[j]) - (q[j] - p[j]) * (r[i] - p[i])

    for k in range(3):
        c, d = triangle[k], triangle[(k + 1) % 3]
        if turn(a, b, c) * turn(a, b, d) <= 0 and turn(c, d, a) * turn(c, d, b) <= 0:
            if any((turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b))):
                return True
    return False
