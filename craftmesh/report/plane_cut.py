"""A plane's cut through tetrahedra, as polygons."""

import numpy as np

# By which of a tetrahedron's corners lie above the plane (bit k for corner k): the edges that the plane
# crosses, in an order that goes round the polygon.
_CROSSED: dict[int, tuple[tuple[int, int], ...]] = {}
for _corner in range(4):
    _others = [k for k in range(4) if k != _corner]
    _CROSSED[1 << _corner] = _CROSSED[15 - (1 << _corner)] = tuple((_corner, k) for k in _others)
for _a, _b in ((0, 1), (0, 2), (0, 3)):
    _c, _d = (k for k in range(4) if k not in (_a, _b))
    _mask = (1 << _a) | (1 << _b)
    _CROSSED[_mask] = _CROSSED[15 - _mask] = ((_a, _c), (_a, _d), (_b, _d), (_b, _c))


def cut_tets(
    points: np.ndarray, tets: np.ndarray, origin: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the polygons (p, 4, 3) in which a plane cuts tetrahedra (m, 4), and which those are (p,).

    points (n, 3); the plane goes through `origin` square to `normal`. A triangle has its last corner twice.
    Corners on the plane count as below it.
    """
    above = (points - origin) @ normal > 0
    mask = above[tets] @ (1 << np.arange(4))
    polygons, rows = [np.zeros((0, 4, 3))], [np.zeros(0, np.int64)]
    for kind, edges in _CROSSED.items():
        row = np.flatnonzero(mask == kind)
        corners = [_crossing(points, tets[row][:, edge], origin, normal) for edge in edges]
        polygons.append(np.stack([*corners, corners[-1]][:4], axis=1))
        rows.append(row)
    order = np.argsort(np.concatenate(rows), kind="stable")
    return np.concatenate(polygons)[order], np.concatenate(rows)[order]


def _crossing(points: np.ndarray, edges: np.ndarray, origin: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return the points (k, 3) at which the plane crosses edges (k, 2)."""
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    high, low = (a - origin) @ normal, (b - origin) @ normal
    return a + (high / (high - low))[:, None] * (b - a)
