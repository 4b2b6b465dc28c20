"""Triangulate the crack in its own parameters: traces and front kept, interior points to the sizes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapely

from craftmesh.errors import CraftmeshError
from craftmesh.insertion.kernels import planar
from craftmesh.insertion.kernels.planar_smoothing import smooth
from craftmesh.surface.connectivity import facet_edges

SPACING = 0.72  # least distance of an interior point from others, in target edge lengths
CLEARANCE = 0.4  # least distance from a fixed edge, in target edge lengths


@dataclass(eq=False)
class Patch:
    """A planar triangulation under refinement; arrays have spare rows, `used` = [points, triangles]."""

    uv: np.ndarray
    corners: np.ndarray
    across: np.ndarray
    fixed: np.ndarray
    used: np.ndarray

    @property
    def triangles(self) -> np.ndarray:
        return self.corners[: self.used[1]]


def triangulate(uv, segments, loose, is_inside: Callable) -> Patch:
    """Return the constrained Delaunay triangulation of the polygons that segments (k, 2) bound.

    uv (n, 2); loose: points that lie on no segment. Only polygons with is_inside(uv) > 0 count. Every
    segment inside is an edge, also one that bounds no polygon. Raises CraftmeshError if one is lost.
    """
    lines = shapely.linestrings(uv[segments])
    polygons = shapely.get_parts(shapely.polygonize(lines))
    if not len(polygons):
        raise CraftmeshError("the crack's front and traces bound no area; move the crack a little")
    witness = shapely.get_coordinates(shapely.point_on_surface(polygons))
    polygons = polygons[is_inside(witness) > 0]
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(polygons))
    parts = shapely.get_parts(parts)
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    ids = _ids_of(uv, np.unique(np.concatenate([segments.ravel(), loose])), corners.reshape(-1, 2)).reshape(
        -1, 3
    )
    a, b, c = (uv[ids[:, i]] for i in range(3))
    turned = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    ids[turned] = ids[turned][:, ::-1]
    patch = _linked(uv, ids, segments)
    _add_missing(patch, segments, loose)
    return patch


def _ids_of(uv, candidates, coordinates) -> np.ndarray:
    """Return the point id of each row of coordinates, found by equality."""
    known = {tuple(row): i for i, row in zip(candidates.tolist(), uv[candidates].tolist())}
    return np.array([known[tuple(row)] for row in coordinates.tolist()], np.int64)


def _padded(array, rows: int, fill) -> np.ndarray:
    return np.concatenate([array, np.full((rows, *array.shape[1:]), fill, array.dtype)])


def _with_room(uv, corners, across, fixed, points: int) -> Patch:
    """Return a patch with room for `points` more points."""
    used = np.array([len(uv), len(corners)])
    return Patch(
        _padded(np.asarray(uv, float), points, 0.0),
        _padded(corners, 2 * points, -1),
        _padded(across, 2 * points, -1),
        _padded(fixed, 2 * points, False),
        used,
    )


def _linked(uv, triangles, segments) -> Patch:
    """Return the patch of triangles with their neighbours; segments and the rim are fixed."""
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
    return _with_room(uv, triangles, across, fixed, len(segments) + 16)


def _edges_present(patch: Patch) -> set:
    return set(map(tuple, np.sort(facet_edges(patch.triangles), axis=1).tolist()))


def _add_missing(patch: Patch, segments, loose) -> None:
    """Insert points and recover segments that bound no polygon."""
    present = _edges_present(patch)
    missing = [pair for pair in np.sort(segments, axis=1).tolist() if tuple(pair) not in present]
    absent = np.setdiff1d(np.concatenate([np.array(missing, np.int64).ravel(), loose]), patch.triangles)
    stack = np.empty(1 << 16, np.int64)
    for point in absent.tolist():
        t = planar.locate(patch.uv, patch.corners, patch.across, patch.fixed, 0, point, True)
        if t < 0:
            t = _holding(patch, patch.uv[point])
        if t < 0 or planar.insert_point(
            patch.uv, patch.corners, patch.across, patch.fixed, patch.used, t, point, stack
        ):
            raise CraftmeshError(
                f"a trace point at (u, v) = {patch.uv[point].tolist()} lies outside the crack"
            )
    for a, b in missing:
        if not planar.recover_edge(patch.uv, patch.corners, patch.across, patch.fixed, patch.used, a, b):
            raise CraftmeshError(
                f"a trace edge at (u, v) = {patch.uv[a].tolist()} crosses another; move the crack a little"
            )
        _fix_edge(patch, a, b)


def _fix_edge(patch: Patch, a: int, b: int) -> None:
    following = np.roll(patch.triangles, -1, axis=1)
    along = (patch.triangles == a) & (following == b) | (patch.triangles == b) & (following == a)
    patch.fixed[: patch.used[1]] |= along


def _holding(patch: Patch, position) -> int:
    corner = patch.uv[patch.triangles]
    edge = np.roll(corner, -1, axis=1) - corner
    step = position - corner
    side = edge[..., 0] * step[..., 1] - edge[..., 1] * step[..., 0]
    inside = np.flatnonzero((side >= 0).all(axis=1))
    return int(inside[0]) if len(inside) else -1


def refine(patch: Patch, size_at: Callable, frozen_points, rounds: int = 60) -> Patch:
    """Insert circumcentres of triangles larger than size_at(uv) until none is left; then smooth.

    frozen_points (k, 3): triangles (sorted ids) that stay as they are.
    """
    patch = _grown(patch, size_at)
    frozen_keys = {tuple(row) for row in np.sort(frozen_points, axis=1).tolist()}
    stack = np.empty(1 << 20, np.int64)
    fixed_points = patch.used[0].copy()
    arrays = (patch.uv, patch.corners, patch.across, patch.fixed)
    planar.legalise_all(*arrays, patch.used)
    for _ in range(rounds):
        centre, radius = _circumcircles(patch)
        rows, centre, target = _oversized(patch, centre, radius, size_at)
        frozen = np.zeros(len(patch.corners), bool)
        if frozen_keys:
            sorted_ids = np.sort(patch.triangles, axis=1).tolist()
            frozen[: patch.used[1]] = [tuple(row) in frozen_keys for row in sorted_ids]
        if not len(rows) or not planar.insert_spaced(
            *arrays, frozen, patch.used, rows, centre, SPACING * 0.98 * target, CLEARANCE * target, stack
        ):
            break
    for _ in range(4):
        smooth_points(patch, np.arange(fixed_points, patch.used[0]))
        planar.legalise_all(*arrays, patch.used)
    return patch


def smooth_points(patch: Patch, movable) -> None:
    """One sweep of guarded centroid smoothing over the given points."""
    flat = patch.triangles.ravel()
    start = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=len(patch.uv)))])
    smooth(patch.uv, patch.corners, start, np.argsort(flat, kind="stable") // 3, movable)


def _grown(patch: Patch, size_at) -> Patch:
    """Return the patch with room for the points that its area and sizes call for."""
    corner = patch.uv[patch.triangles]
    u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() / 2
    low = np.min(size_at(patch.uv[np.unique(patch.triangles)]))
    more = int(min(4 * area / low**2, 5e6)) + 4096
    points, triangles = patch.used
    return _with_room(
        patch.uv[:points],
        patch.corners[:triangles],
        patch.across[:triangles],
        patch.fixed[:triangles],
        more,
    )


def _circumcircles(patch: Patch) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = (patch.uv[patch.triangles[:, i]] for i in range(3))
    u, v = b - a, c - a
    twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    uu, vv = (u**2).sum(axis=1), (v**2).sum(axis=1)
    with np.errstate(all="ignore"):
        x = (v[:, 1] * uu - u[:, 1] * vv) / (2 * twice)
        y = (u[:, 0] * vv - v[:, 0] * uu) / (2 * twice)
    return a + np.stack([x, y], axis=1), np.hypot(x, y)


def _oversized(patch: Patch, centre, radius, size_at):
    """Return the triangles whose circumradius exceeds SPACING targets, worst first."""
    rows = np.flatnonzero(np.isfinite(radius))
    low, high = patch.uv[patch.triangles].min(axis=(0, 1)), patch.uv[patch.triangles].max(axis=(0, 1))
    rows = rows[((centre[rows] >= low) & (centre[rows] <= high)).all(axis=1)]
    target = size_at(centre[rows]) if len(rows) else np.zeros(0)
    excess = radius[rows] / target
    keep = excess > SPACING
    rows, target, excess = rows[keep], target[keep], excess[keep]
    order = np.argsort(-excess, kind="stable")
    return rows[order], centre[rows[order]], target[order]


def split_ears(patch: Patch, is_front_node) -> int:
    """Split free edges that join two front nodes, so that every crack facet has a corner off the front."""
    split = 0
    while True:
        ends = patch.triangles, np.roll(patch.triangles, -1, axis=1)
        known = np.concatenate([is_front_node, np.zeros(len(patch.uv) - len(is_front_node), bool)])
        t, i = np.nonzero(known[ends[0]] & known[ends[1]] & ~patch.fixed[: patch.used[1]])
        if not len(t):
            return split
        if patch.used[0] >= len(patch.uv) or patch.used[1] + 2 > len(patch.corners):
            raise CraftmeshError("the crack's patch ran out of room; use larger sizes")
        point = patch.used[0]
        a, b = ends[0][t[0], i[0]], ends[1][t[0], i[0]]
        patch.uv[point] = (patch.uv[a] + patch.uv[b]) / 2
        planar.split_edge(patch.corners, patch.across, patch.fixed, patch.used, t[0], i[0], point)
        patch.used[0] += 1
        split += 1
