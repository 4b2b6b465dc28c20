"""Triangulate the crack in its own parameters: traces and front kept, interior points to the sizes."""

from collections.abc import Callable

import numpy as np
import shapely

from craftmesh.cracks.in_plane import doubled_areas
from craftmesh.errors import CraftmeshError, told
from craftmesh.insertion.kernels import planar
from craftmesh.insertion.kernels.planar import Candidates, Planar
from craftmesh.surface.connectivity import facet_edges, rows_among
from craftmesh.surface.rounding import ROUNDING

# Shares of the target edge, chosen by hand. An even triangle of target edges has the circumradius
# 0.577, so that SPACING leaves triangles up to a quarter larger.
SPACING = 0.72  # a triangle of a larger circumradius gets a point; also the point's distance from others
CLEARANCE = 0.4  # least distance of an interior point from a fixed edge
BARELY = 0.98  # of SPACING is kept, so that rounding does not refuse the centre of a circle just larger
MOST_POINTS = 5e6  # that room is made for: 0.6 GB


def triangulate(
    uv: np.ndarray, segments: np.ndarray, loose: np.ndarray, is_inside: Callable[[np.ndarray], np.ndarray]
) -> Planar:
    """Return the constrained Delaunay triangulation of the polygons that segments (k, 2) bound.

    uv (n, 2); loose: points that lie on no segment. Those and segments off the polygons are left out, as a
    corner of the box that the crack touches, or a bit of a mouth between two crossings of a front that
    grazes it. Only polygons with is_inside(uv) > 0 count. Every segment inside is an edge, also one that
    bounds no polygon. Raises CraftmeshError if one is lost.
    """
    lines = shapely.linestrings(uv[segments])
    polygons = shapely.get_parts(shapely.polygonize(lines))
    if len(polygons):
        witness = shapely.get_coordinates(shapely.point_on_surface(polygons))
        polygons = polygons[is_inside(witness) > 0]
    if not len(polygons):
        raise CraftmeshError(
            "no material there: the crack lies in no grain, or only touches one; expected a crack within "
            "the material: move it"
        )
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
    """Tell which places (n, 2) lie in one of the polygons, or off them by rounding alone."""
    tree = shapely.STRtree(polygons)
    low, high = shapely.total_bounds(polygons).reshape(2, 2)
    near = np.zeros(len(places), bool)
    near[tree.query(shapely.points(places), "dwithin", ROUNDING * np.linalg.norm(high - low))[0]] = True
    return near


def _ids_of(uv: np.ndarray, candidates: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Return the point id of each row of coordinates, found by equality."""
    known = {tuple(row): i for i, row in zip(candidates.tolist(), uv[candidates].tolist())}
    return np.array([known[tuple(row)] for row in coordinates.tolist()], np.int64)


def _padded(array: np.ndarray, rows: int, fill: float) -> np.ndarray:
    return np.concatenate([array, np.full((rows, *array.shape[1:]), fill, array.dtype)])


def _with_room(patch: Planar, points: int) -> Planar:
    """Return a copy of the patch with room for `points` more points, each of which brings two triangles."""
    old_points, old_triangles = patch.used
    return Planar(
        _padded(patch.uv[:old_points], points, 0.0),
        _padded(patch.corners[:old_triangles], 2 * points, -1),
        _padded(patch.across[:old_triangles], 2 * points, -1),
        _padded(patch.fixed[:old_triangles], 2 * points, False),
        patch.used.copy(),
    )


def _linked(uv: np.ndarray, triangles: np.ndarray, segments: np.ndarray) -> Planar:
    """Return the patch of triangles with their neighbours; segments and the rim are fixed.

    There is room to insert every point of uv that is in no triangle yet.
    """
    directed = facet_edges(triangles)
    stride = len(uv) + 1
    key = directed[:, 0] * stride + directed[:, 1]
    back = directed[:, 1] * stride + directed[:, 0]
    order = np.argsort(key)
    if (np.diff(key[order]) == 0).any():
        raise CraftmeshError("the crack's triangulation folds over itself; move the crack a little")
    slot = np.minimum(np.searchsorted(key, back, sorter=order), len(key) - 1)
    across = np.where(key[order[slot]] == back, order[slot] // 3, -1).reshape(-1, 3)
    wanted = np.sort(segments, axis=1) @ np.array([stride, 1])
    fixed = np.isin(np.sort(directed, axis=1) @ np.array([stride, 1]), wanted).reshape(-1, 3) | (across < 0)
    used = np.array([len(uv), len(triangles)])
    return _with_room(Planar(np.asarray(uv, float), triangles, across, fixed, used), len(uv))


def _add_missing(patch: Planar, segments: np.ndarray, loose: np.ndarray) -> None:
    """Insert the points and recover the segments that bound no polygon."""
    present = set(map(tuple, np.sort(facet_edges(patch.triangles), axis=1).tolist()))
    missing = [pair for pair in np.sort(segments, axis=1).tolist() if tuple(pair) not in present]
    absent = np.setdiff1d(np.concatenate([np.array(missing, np.int64).ravel(), loose]), patch.triangles)
    for point in absent.tolist():
        t = planar.locate(patch, 0, point, True)
        if t < 0:
            t = _holding(patch, patch.uv[point])
        if t < 0 or planar.insert_point(patch, t, point) == planar.BLOCKED:
            raise CraftmeshError(
                f"a trace point at (u, v) = {told(patch.uv[point])} lies outside the crack; move the "
                "crack a little"
            )
    for a, b in missing:
        if not planar.recover_edge(patch, a, b):
            raise CraftmeshError(
                f"a trace edge at (u, v) = {told(patch.uv[a])} crosses another; move the crack a little"
            )
        _fix_edge(patch, a, b)


def _fix_edge(patch: Planar, a: int, b: int) -> None:
    following = np.roll(patch.triangles, -1, axis=1)
    along = (patch.triangles == a) & (following == b) | (patch.triangles == b) & (following == a)
    patch.fixed[: patch.used[1]] |= along


def _holding(patch: Planar, position: np.ndarray) -> int:
    """Return a triangle that holds the position (2,), -1 for none."""
    corner = patch.uv[patch.triangles]
    edge = np.roll(corner, -1, axis=1) - corner
    step = position - corner
    side = edge[..., 0] * step[..., 1] - edge[..., 1] * step[..., 0]
    inside = np.flatnonzero((side >= 0).all(axis=1))
    return int(inside[0]) if len(inside) else -1


def refine(patch: Planar, size_at: Callable[[np.ndarray], np.ndarray], kept: np.ndarray) -> Planar:
    """Return the patch with circumcentres of triangles larger than size_at(uv) inserted until none is left.

    kept (k, 3): triangles that stay as they are, by their points.
    Raises CraftmeshError where that takes more than MOST_POINTS.
    """
    patch = _with_room(patch, _points_wanted(patch, size_at))
    planar.legalise_all(patch)
    while planar.insert_spaced(patch, _circumcentres(patch, size_at), is_among(patch, kept)):
        pass
    refuse_full(patch)
    return patch


def refuse_full(patch: Planar) -> None:
    """Raise CraftmeshError where the patch has no room for one more point."""
    if not planar.has_room(patch):
        raise CraftmeshError(
            f"the crack's patch is full with {int(patch.used[1])} triangles; use larger sizes"
        )


def is_among(patch: Planar, triangles: np.ndarray) -> np.ndarray:
    """Tell which rows of the patch are one of `triangles` (k, 3), in any order of the corners."""
    found = np.zeros(len(patch.corners), bool)
    if len(triangles):
        found[: patch.used[1]] = rows_among(patch.triangles, triangles) >= 0
    return found


def _points_wanted(patch: Planar, size_at: Callable[[np.ndarray], np.ndarray]) -> int:
    """Return four points per square of the least size on the patch's area, and some more for small ones."""
    area = np.abs(doubled_areas(patch.uv, patch.triangles)).sum() / 2
    low = np.min(size_at(patch.uv[np.unique(patch.triangles)]))
    return int(min(4 * area / low**2, MOST_POINTS)) + 4096


def _circumcentres(patch: Planar, size_at: Callable[[np.ndarray], np.ndarray]) -> Candidates:
    """Return the circumcentres of triangles whose circumradius exceeds SPACING targets, worst first."""
    centre, radius = circumcircles(patch)
    rows = np.flatnonzero(np.isfinite(radius))
    corner = patch.uv[patch.triangles]
    low, high = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
    rows = rows[((centre[rows] >= low) & (centre[rows] <= high)).all(axis=1)]
    target = size_at(centre[rows]) if len(rows) else np.zeros(0)
    excess = radius[rows] / target
    keep = excess > SPACING
    rows, target, excess = rows[keep], target[keep], excess[keep]
    order = np.argsort(-excess, kind="stable")
    rows, target = rows[order], target[order]
    return Candidates(centre[rows], rows, SPACING * BARELY * target, CLEARANCE * target)


def circumcircles(patch: Planar) -> tuple[np.ndarray, np.ndarray]:
    """Return centres (t, 2) and radii (t,), not finite for triangles without area."""
    a, b, c = (patch.uv[patch.triangles[:, i]] for i in range(3))
    u, v = b - a, c - a
    twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    uu, vv = (u**2).sum(axis=1), (v**2).sum(axis=1)
    with np.errstate(all="ignore"):
        x = (v[:, 1] * uu - u[:, 1] * vv) / (2 * twice)
        y = (u[:, 0] * vv - v[:, 0] * uu) / (2 * twice)
    return a + np.stack([x, y], axis=1), np.hypot(x, y)


def split_chords(patch: Planar, is_chord: Callable[[Planar], np.ndarray]) -> int:
    """Split free edges at their middles, one at a time, as long as is_chord(patch) tells (t, 3) any.

    Edge i of a triangle runs from its corner i to its corner i + 1. Returns how many were split.
    """
    split = 0
    while True:
        t, i = np.nonzero(is_chord(patch) & ~patch.fixed[: patch.used[1]])
        if not len(t):
            return split
        refuse_full(patch)
        point = patch.used[0]
        a, b = patch.corners[t[0], i[0]], patch.corners[t[0], (i[0] + 1) % 3]
        patch.uv[point] = (patch.uv[a] + patch.uv[b]) / 2
        planar.split_inner_edge(patch, t[0], i[0], point)
        patch.used[0] += 1
        split += 1


def front_chords(is_front_node: np.ndarray) -> Callable[[Planar], np.ndarray]:
    """Return what tells the edges (t, 3) of a patch that join two front nodes.

    They would be ears (craftmesh.surface.front); traces that join front nodes are split before.
    is_front_node (n,): of the points that the patch began with.
    """

    def chords(patch: Planar) -> np.ndarray:
        known = _padded(is_front_node, int(patch.used[0]) - len(is_front_node), False)
        on = known[patch.triangles]
        return on & np.roll(on, -1, axis=1)

    return chords


def wall_chords(walls: np.ndarray) -> Callable[[Planar], np.ndarray]:
    """Return what tells the edges (t, 3) between points of a wall, of triangles with all corners on it.

    A wall is a box plane or a grain boundary; walls (n, w) bool: those of the points that the patch began
    with. Such a triangle of a curved crack would lie in the wall, or run through it.
    """

    def chords(patch: Planar) -> np.ndarray:
        known = _padded(walls, int(patch.used[0]) - len(walls), False)
        within = known[patch.triangles].all(axis=1).any(axis=1)
        return np.repeat(within[:, None], 3, axis=1)

    return chords
