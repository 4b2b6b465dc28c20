"""Plane triangulations of a crack: between given segments, and of a polygon at a given spacing."""

from collections.abc import Callable

import numpy as np
import scipy
import shapely

from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.surface.connectivity import compact, facet_edges
from craftmesh.surface.kernels import planar
from craftmesh.surface.kernels.planar import Planar
from craftmesh.surface.rounding import ROUNDING

APART = 0.6  # smallest distance of grid points from given points and the boundary, in spacings


def filled(polygon: shapely.Polygon, given: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 2) and triangles (m, 3), counter-clockwise, that fill the polygon.

    The points are the vertices of the polygon's boundary, subdivided to the spacing, the given points (k,
    2) inside it, and a hexagonal grid between them. Raise CraftmeshError if the boundary touches or crosses
    itself.
    """

    rings = [_spaced(np.asarray(ring.coords), spacing) for ring in (polygon.exterior, *polygon.interiors)]
    rounding = ROUNDING * np.ptp(rings[0], axis=0).max()
    off = shapely.distance(polygon.boundary, shapely.points(given))
    inside = given[shapely.contains_xy(polygon, *given.T) & (off > rounding)]
    free = _grid(polygon, spacing)
    fixed = np.concatenate([*rings, inside])
    if len(free):
        free = free[scipy.spatial.KDTree(fixed).query(free)[0] > APART * spacing]
    uv = np.concatenate([fixed, free])
    _, first, same = np.unique(np.round(uv / rounding), axis=0, return_index=True, return_inverse=True)
    ids, count = first[same.ravel()], sum(map(len, rings))
    ends = np.delete(np.arange(count), np.cumsum([len(ring) for ring in rings]) - 1)
    segments = np.column_stack([ids[ends], ids[ends + 1]])
    segments = segments[segments[:, 0] != segments[:, 1]]
    if not polygon.is_valid:
        raise CraftmeshError(
            "the crack's outline touches or crosses itself; give an outline without crossings"
        )
    loose = np.setdiff1d(ids[count:], segments)
    patch = triangulate(uv, segments, loose, lambda at: shapely.contains_xy(polygon, *at.T) - 0.5)
    planar.legalise_all(patch)
    points, triangles, _ = compact(uv, patch.triangles)
    return points, triangles


def _spaced(ring: np.ndarray, spacing: float) -> np.ndarray:
    """Return the closed ring (k, 2) with its edges subdivided until none is longer than the spacing."""
    parts = [ring[:1]]
    for a, b in zip(ring[:-1], ring[1:]):
        count = max(int(np.ceil(np.linalg.norm(b - a) / spacing)), 1)
        share = np.arange(1, count + 1)[:, None] / count
        parts.append(np.where(share == 1, b, a + share * (b - a)))
    return np.concatenate(parts)


def _grid(polygon: shapely.Polygon, spacing: float) -> np.ndarray:
    """Return points (k, 2) of a hexagonal grid in the polygon, APART spacings or more from its boundary."""
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
    """Return twice the areas (m,) of triangles (m, 3) on points (n, 2), negative if clockwise."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])


def triangulate(
    uv: np.ndarray, segments: np.ndarray, loose: np.ndarray, is_inside: Callable[[np.ndarray], np.ndarray]
) -> Planar:
    """Return the constrained Delaunay triangulation of the polygons that segments (k, 2) bound.

    uv (n, 2). loose: ids of points that lie on no segment. Only polygons with a point where is_inside(uv) >
    0 are filled. Loose points and segments outside these are dropped: a box corner that the crack touches,
    or a bit of mouth between two crossings of a grazing front. Each segment inside becomes an edge, even if
    it bounds no polygon. Raise CraftmeshError if a segment cannot become an edge, or no polygon is filled.
    """
    lines = shapely.linestrings(uv[segments])
    polygons = shapely.get_parts(shapely.polygonize(lines))
    if len(polygons):
        witness = shapely.get_coordinates(shapely.point_on_surface(polygons))
        polygons = polygons[is_inside(witness) > 0]
    if not len(polygons):
        raise CraftmeshError("the crack lies in no grain, or only touches one; move it into the material")
    loose = loose[_are_near(uv[loose], polygons)]
    segments = segments[_are_near(uv[segments].mean(axis=1), polygons)]
    parts = shapely.get_parts(shapely.get_parts(shapely.constrained_delaunay_triangles(polygons)))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    known = np.unique(np.concatenate([segments.ravel(), loose]))
    triangles = _ids_of(uv, known, corners.reshape(-1, 2)).reshape(-1, 3)
    turned = doubled_areas(uv, triangles) < 0
    triangles[turned] = triangles[turned][:, ::-1]
    patch = _linked(uv, triangles, segments)
    _add_missing(patch, segments, loose)
    return patch


def _are_near(places: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of places (n, 2) that lie in one of the polygons, within rounding."""
    tree = shapely.STRtree(polygons)
    low, high = shapely.total_bounds(polygons).reshape(2, 2)
    near = np.zeros(len(places), bool)
    near[tree.query(shapely.points(places), "dwithin", ROUNDING * np.linalg.norm(high - low))[0]] = True
    return near


def _ids_of(uv: np.ndarray, candidates: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Return the ids of the candidate points that equal the rows of coordinates (k, 2) exactly."""
    known = {tuple(row): i for i, row in zip(candidates.tolist(), uv[candidates].tolist())}
    return np.array([known[tuple(row)] for row in coordinates.tolist()], np.int64)


def with_room(patch: Planar, points: int) -> Planar:
    """Return a copy of a triangulation with spare rows for `points` points, and two triangles for each."""
    used_points, used_triangles = patch.used
    return Planar(
        _padded(patch.uv[:used_points], points, 0.0),
        _padded(patch.corners[:used_triangles], 2 * points, -1),
        _padded(patch.across[:used_triangles], 2 * points, -1),
        _padded(patch.fixed[:used_triangles], 2 * points, False),
        patch.used.copy(),
    )


def _padded(array: np.ndarray, rows: int, fill: float) -> np.ndarray:
    return np.concatenate([array, np.full((rows, *array.shape[1:]), fill, array.dtype)])


def _linked(uv: np.ndarray, triangles: np.ndarray, segments: np.ndarray) -> Planar:
    """Return triangles (m, 3) with their neighbours, and with segments and boundary edges marked as fixed.

    The result has spare rows for as many points as uv has.
    """
    directed = facet_edges(triangles)
    stride = len(uv) + 1
    key = directed[:, 0] * stride + directed[:, 1]
    back = directed[:, 1] * stride + directed[:, 0]
    order = np.argsort(key)
    if (np.diff(key[order]) == 0).any():
        raise CraftmeshError("the crack's facets would overlap each other; move the crack a little")
    slot = np.minimum(np.searchsorted(key, back, sorter=order), len(key) - 1)
    across = np.where(key[order[slot]] == back, order[slot] // 3, -1).reshape(-1, 3)
    wanted = np.sort(segments, axis=1) @ np.array([stride, 1])
    fixed = np.isin(np.sort(directed, axis=1) @ np.array([stride, 1]), wanted).reshape(-1, 3) | (across < 0)
    used = np.array([len(uv), len(triangles)])
    return with_room(Planar(np.asarray(uv, float), triangles, across, fixed, used), len(uv))


def _add_missing(patch: Planar, segments: np.ndarray, loose: np.ndarray) -> None:
    """Insert the loose points and segments that the triangulation lacks; changes `patch` in place.

    Raise CraftmeshError if a point lies outside or a segment crosses another one.
    """
    present = set(map(tuple, np.sort(facet_edges(patch.triangles), axis=1).tolist()))
    missing = [pair for pair in np.sort(segments, axis=1).tolist() if tuple(pair) not in present]
    absent = np.setdiff1d(np.concatenate([np.array(missing, np.int64).ravel(), loose]), patch.triangles)
    t = 0
    for point in absent.tolist():
        t = planar.locate(patch, max(t, 0), point, True)
        if t < 0:
            t = _holding(patch, patch.uv[point])
        if t < 0 or planar.insert_point(patch, t, point) == planar.BLOCKED:
            raise CraftmeshError(
                f"a point where the crack meets a boundary, (u, v) = {rounded_values(patch.uv[point])} "
                f"in its plane, "
                "lies outside the crack; move the crack a little"
            )
    for a, b in missing:
        if not planar.recover_edge(patch, a, b):
            raise CraftmeshError(
                "lines along which the crack meets boundaries cross near (u, v) = "
                f"{rounded_values(patch.uv[a])} in its plane; move the crack a little"
            )
        _fix_edge(patch, a, b)


def _fix_edge(patch: Planar, a: int, b: int) -> None:
    """Mark the edge a-b as fixed in both of its triangles."""
    following = np.roll(patch.triangles, -1, axis=1)
    along = (patch.triangles == a) & (following == b) | (patch.triangles == b) & (following == a)
    patch.fixed[: patch.used[1]] |= along


def _holding(patch: Planar, position: np.ndarray) -> int:
    """Return a triangle that contains the position (2,), -1 if none does."""
    corner = patch.uv[patch.triangles]
    edge = np.roll(corner, -1, axis=1) - corner
    step = position - corner
    side = edge[..., 0] * step[..., 1] - edge[..., 1] * step[..., 0]
    inside = np.flatnonzero((side >= 0).all(axis=1))
    return int(inside[0]) if len(inside) else -1
