"""A polygon in the plane of a crack filled with triangles, through points that it is given."""

import numpy as np
import shapely
from scipy.spatial import Delaunay, KDTree

from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import compact, facet_edges
from craftmesh.surface.rounding import ROUNDING

APART = 0.6  # of the spacing: free points keep this far from given ones and from the boundary
ROUNDS = 12  # of halvings of boundary edges that the triangulation leaves out; two are usual


def filled(polygon: shapely.Polygon, given: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 2) and triangles (m, 3), counter-clockwise, that fill the polygon.

    Every point of the polygon's boundary and every given one (k, 2) inside it is a point; between them lie
    points of a hexagonal grid of that spacing. Boundary edges may be halved. Raises CraftmeshError where
    the boundary cannot be kept, as where it touches itself.
    """
    rings = [_spaced(np.asarray(ring.coords), spacing) for ring in (polygon.exterior, *polygon.interiors)]
    inside = given[shapely.contains_xy(polygon, given[:, 0], given[:, 1])] if len(given) else given
    for _ in range(ROUNDS):
        boundary = np.concatenate([ring[:-1] for ring in rings])
        fixed = _distinct(np.concatenate([boundary, inside]), polygon)
        free = _grid(polygon, spacing)
        if len(free):
            free = free[KDTree(fixed).query(free)[0] > APART * spacing]
        points = np.concatenate([fixed, free])
        triangles = Delaunay(points).simplices.astype(np.int64)
        centre = points[triangles].mean(axis=1)
        twice = doubled_areas(points, triangles)
        kept = shapely.contains_xy(polygon, centre[:, 0], centre[:, 1]) & (
            np.abs(twice) > ROUNDING * spacing**2
        )
        triangles = np.where((twice < 0)[:, None], triangles[:, ::-1], triangles)[kept]
        rings, complete = _with_halves(rings, points, triangles)
        if complete:
            points, triangles, _ = compact(points, triangles)
            return points, triangles
    raise CraftmeshError("the crack's outline touches or crosses itself; expected one without crossings")


def _spaced(ring: np.ndarray, spacing: float) -> np.ndarray:
    """Return the closed ring (k, 2) with its edges parted until none is longer than the spacing."""
    parts = [ring[:1]]
    for a, b in zip(ring[:-1], ring[1:]):
        count = max(int(np.ceil(np.linalg.norm(b - a) / spacing)), 1)
        share = np.arange(1, count + 1)[:, None] / count
        parts.append(np.where(share == 1, b, a + share * (b - a)))
    return np.concatenate(parts)


def _distinct(points: np.ndarray, polygon: shapely.Polygon) -> np.ndarray:
    """Return the points (k, 2) in order, of those within ROUNDING of each other the first."""
    x0, y0, x1, y1 = polygon.bounds
    step = ROUNDING * max(x1 - x0, y1 - y0)
    _, first = np.unique(np.round(points / step), axis=0, return_index=True)
    return points[np.sort(first)]


def _grid(polygon: shapely.Polygon, spacing: float) -> np.ndarray:
    """Return the points (k, 2) of a hexagonal grid within the polygon, APART from its boundary."""
    x0, y0, x1, y1 = polygon.bounds
    step = spacing * np.sqrt(0.75)
    rows = []
    for number, y in enumerate(np.arange(y0, y1, step)):
        x = np.arange(x0 + 0.5 * spacing * (number % 2), x1, spacing)
        rows.append(np.column_stack([x, np.full(len(x), y)]))
    points = np.concatenate(rows) if rows else np.zeros((0, 2))
    inner = polygon.buffer(-APART * spacing)
    return points[shapely.contains_xy(inner, points[:, 0], points[:, 1])]


def doubled_areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return twice the areas (m,) of triangles (m, 3) of points (n, 2), negative where they turn right."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])


def _with_halves(
    rings: list[np.ndarray], points: np.ndarray, triangles: np.ndarray
) -> tuple[list[np.ndarray], bool]:
    """Return the rings with the edges halved that no triangle has, and whether there was none."""
    edges = set(map(tuple, np.sort(facet_edges(triangles), axis=1).tolist()))
    tree, complete, result = KDTree(points), True, []
    for ring in rings:
        ids = tree.query(ring)[1].tolist()
        parts = [ring[:1]]
        for k, (a, b) in enumerate(zip(ids[:-1], ids[1:])):
            if a != b and (min(a, b), max(a, b)) not in edges:
                parts.append((ring[k] + ring[k + 1])[None] / 2)
                complete = False
            parts.append(ring[k + 1 : k + 2])
        result.append(np.concatenate(parts))
    return result, complete
