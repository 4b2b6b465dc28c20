"""Cracks from measurements: points with an ordered front, only fronts, or a path in a plane."""

from collections.abc import Sequence

import numpy as np
import shapely

from craftmesh.cracks.behind_front import Plane, cracked_part
from craftmesh.cracks.fit_bounds import (
    SCATTERS,
    Numbers,
    refuse_other_place,
    refuse_step,
    scatter_of,
    within_bound,
)
from craftmesh.cracks.height_fit import fitted_heights, interpolation
from craftmesh.cracks.in_plane import filled
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.polyline import feet, polyline
from craftmesh.cracks.prescription import frame_along, frame_of, semi_axes, vector
from craftmesh.cracks.series import GivenSurface
from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.rounding import ON_PLANE, ROUNDING

PER_TRIANGLE = 2.0  # measured points per triangle at the default spacing: four per unknown height
ACROSS_FRONT = 40  # number of edges along the fronts at the default spacing, without measured points
MOST_TRIANGLES = 400_000  # largest surface that is fitted; it takes a minute of one core


def crack_through_points(
    cloud: np.ndarray,
    fronts: Sequence[np.ndarray],
    box: np.ndarray,
    spacing: float | None = None,
    l_min: float | None = None,
) -> tuple[GivenSurface, Numbers]:
    """Return the surface within the fronts that fits a measured cloud best, and a report on the fit.

    cloud (n, 3), in any order. fronts: polylines (k, 3), closed (first point repeated at the end), or one
    open front that ends on the box (2, 3). The surface is single-valued over the least-squares plane and
    contains the fronts' points; `spacing` is its edge length (model units; None: two measured points per
    triangle). The report has the distances of the cloud from the surface. It has a note if one exceeds the
    bound: l_min (None: the spacing), or three times the points' scatter if larger. Raise CraftmeshError if
    the root-mean-square distance exceeds it, if cloud and front do not match, if the points lie on a line,
    and as cracked_part does.
    """
    fronts = [finite(f"front {k}", front) for k, front in enumerate(fronts, 1)]
    cloud = finite("point cloud", cloud)
    refuse_other_place(cloud, fronts)
    surface, numbers = _fit_surface(cloud, fronts, fronts, box, spacing, cloud)
    bound = max(numbers["spacing"] if l_min is None else l_min, SCATTERS * scatter_of(cloud))
    return surface, within_bound(
        numbers,
        bound,
        f"{bound:.4g} (l_min, or {SCATTERS:g} times the points' scatter); expected points of one surface "
        "that is single-valued over a plane: remove other points, or give a shorter crack.spacing",
    )


def crack_through_fronts(
    fronts: Sequence[np.ndarray],
    box: np.ndarray,
    spacing: float | None = None,
    inside: Sequence[float] | None = None,
) -> tuple[GivenSurface, Numbers]:
    """Return the surface spanned by the fronts (k, 3) of successive increments, and a report.

    The surface contains all their points and bends as little as possible in between. It lies within the
    last front if that is closed. If that is open, the surface lies between it and the box (2, 3), on the
    side of most points of the earlier fronts and `inside` (3,), or without these on the smaller side. The
    report has the spacing and the number of triangles. Raise CraftmeshError as cracked_part does, or if the
    points lie on a line. spacing: edge length, model units; None: a fortieth of the last front's length.
    """
    fronts = [finite(f"front {k}", front) for k, front in enumerate(fronts, 1)]
    witness = np.reshape(inside if inside is not None else [], (-1, 3))
    return _fit_surface(np.zeros((0, 3)), fronts, fronts[-1:], box, spacing, witness)


def _fit_surface(
    cloud: np.ndarray,
    fronts: Sequence[np.ndarray],
    bounding: Sequence[np.ndarray],
    box: np.ndarray,
    spacing: float | None,
    witnesses: np.ndarray,
) -> tuple[GivenSurface, Numbers]:
    """Return the surface through all fronts, bounded by the fronts `bounding`, that fits the cloud best.

    witnesses (j, 3): points on the cracked side of an open front, in addition to the earlier fronts.
    """
    every, box = np.concatenate([cloud, *fronts]), np.asarray(box, float)
    plane = plane_of(every)
    witnesses = np.concatenate([witnesses, *fronts[: len(fronts) - len(bounding)]])
    polygon = cracked_part(bounding, plane, box, witnesses, plane.to_uvh(every)[:, 2])
    length = _spacing(polygon, plane.to_uvh(cloud), bounding)
    if len(cloud):
        refuse_step(plane.to_uvh(cloud), [plane.to_uvh(front) for front in fronts], length)
    spacing = length if spacing is None else spacing
    return height_surface(polygon, plane, fronts, cloud, spacing, box)


def _spacing(polygon: shapely.Polygon, measured: np.ndarray, fronts: Sequence[np.ndarray]) -> float:
    """Return the default edge length of the surface, from the measured points or else from the fronts."""
    inside = int(shapely.contains_xy(polygon, measured[:, 0], measured[:, 1]).sum())
    if inside:
        return float(np.sqrt(PER_TRIANGLE * 2 * polygon.area / inside))
    lengths = [np.linalg.norm(np.diff(front, axis=0), axis=1).sum() for front in fronts]
    return float(sum(lengths) / ACROSS_FRONT)


def height_surface(
    polygon: shapely.Polygon,
    plane: Plane,
    fronts: Sequence[np.ndarray],
    cloud: np.ndarray,
    spacing: float,
    box: np.ndarray,
) -> tuple[GivenSurface, Numbers]:
    """Return a surface over a polygon in (u, v) that contains the fronts and fits the cloud; and a report.

    Points that almost lie in a plane of the box (2, 3) are moved onto it. The report has the spacing, the
    number of triangles and, with a cloud (n, 3), the number of points used and their distances.
    """
    if polygon.area > MOST_TRIANGLES / 2 * spacing**2:
        raise CraftmeshError(
            f"spacing {spacing:.4g} is too short for a crack of area {polygon.area:.4g}; give at least "
            f"{np.sqrt(2 * polygon.area / MOST_TRIANGLES):.4g}"
        )
    on_fronts = [plane.to_uvh(front) for front in fronts]
    given = np.concatenate([np.zeros((0, 2)), *(uvh[:, :2] for uvh in on_fronts)])
    uv, triangles = filled(polygon, given, spacing)
    measured = plane.to_uvh(cloud)
    height = fitted_heights(uv, triangles, _heights_along(uv, on_fronts), measured, spacing)
    places = np.column_stack([uv, height])
    numbers: Numbers = {"spacing": float(spacing), "triangles": len(triangles)}
    if len(cloud):
        numbers |= _deviation(places, triangles, measured)
    points = plane.lifted(places)
    near = ON_PLANE * np.linalg.norm(box[1] - box[0])
    for corner in box:
        points = np.where(np.abs(points - corner) <= near, corner, points)
    return GivenSurface(points, triangles), numbers


def plane_of(points: np.ndarray) -> Plane:
    """Return the least-squares plane through points (k, 3); its normal's largest component is positive."""
    centre = points.mean(axis=0)
    _, extent, axes = np.linalg.svd(points - centre, full_matrices=False)
    if extent[1] <= ROUNDING * extent[0]:
        raise CraftmeshError(f"the crack's {len(points)} points lie on a line; give points of a surface")
    normal = axes[2] * np.sign(axes[2][np.argmax(np.abs(axes[2]))])
    return Plane(centre, frame_along(normal, axes[0]))


def finite(what: str, points: np.ndarray) -> np.ndarray:
    """Return `points` as an array (k, 3); raise CraftmeshError, naming `what`, unless finite and k >= 3."""
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 3 or not np.isfinite(points).all():
        raise CraftmeshError(
            f"the crack's {what} is an array {points.shape}; expected (k, 3), k >= 3, of finite numbers"
        )
    return points


def _heights_along(uv: np.ndarray, fronts: Sequence[np.ndarray]) -> np.ndarray:
    """Return the heights (n,) of points (n, 2) on a front (k, 3) of u, v and height; NaN elsewhere."""
    heights = np.full(len(uv), np.nan)
    near = ROUNDING * np.ptp(uv, axis=0).max()
    level = np.column_stack([uv, np.zeros(len(uv))])
    for uvh in fronts:
        flat = np.column_stack([uvh[:, :2], np.zeros(len(uvh))])
        moves = np.append(True, (np.diff(flat, axis=0) != 0).any(axis=1))
        line = polyline(flat)
        arc, distance = feet(line, level)
        on = distance <= near
        heights[on] = np.interp(arc[on], line.arc, uvh[moves, 2])
    return heights


def _deviation(places: np.ndarray, triangles: np.ndarray, measured: np.ndarray) -> Numbers:
    """Return the numbers of measured points (k, 3) on and next to the surface, and their distances from it.

    All coordinates are u, v and height. A distance is the height difference times the cosine of the slope.
    Keys: points_used (over or under the surface), points_beside, deviation_rms and deviation_most (of the
    used ones). Raise CraftmeshError if none is used.
    """
    row, triangle, at = interpolation(places[:, :2], triangles, measured[:, :2])
    if not len(row):
        raise CraftmeshError("no point of the cloud is within the front; give both in one unit and place")
    vectors = area_vectors(places, triangles)
    cosine = vectors[:, 2] / np.linalg.norm(vectors, axis=1)
    off = (measured[row, 2] - at @ places[:, 2]) * cosine[triangle]
    return {
        "points_used": len(row),
        "points_beside": len(measured) - len(row),
        "deviation_rms": float(np.sqrt((off**2).mean())),
        "deviation_most": float(np.abs(off).max()),
    }


def crack_along_path(
    path: np.ndarray, options: CrackOptions, increment: int, box: np.ndarray
) -> tuple[GivenSurface, Numbers]:
    """Return the surface that a measured path (k, 2) sweeps through the box (2, 3), and a report.

    path: x along the crack, ascending, and y out of its plane, in units of options.scale model units. Its
    point at x = options.start lies at options.centre; x runs along options.axis, y along options.normal.
    The surface runs from there along the axis to the increment's depth, and backwards out of the box: along
    the path where it was measured, level beyond. It is a ruled surface. Its straight lines, one of which is
    the front, run along normal x axis, turned about the axis by options.slant degrees. Raise CraftmeshError
    if the path turns back or does not cover the crack.
    """
    along, above = np.asarray(path, float).T * options.scale
    along = along - options.start * options.scale
    back = np.flatnonzero(np.diff(along) <= 0)
    if len(back):
        raise CraftmeshError(
            f"the crack's path turns back after its point {back[0] + 1}, x = {path[back[0], 0]:g}; "
            "expected ascending x: sort the points, or remove points where the path overhangs"
        )
    sizes = semi_axes(options, increment)
    depth = sizes[0]
    if not along[0] <= 0 < depth <= along[-1]:
        raise CraftmeshError(
            f"the crack's path goes from {along[0]:.4g} to {along[-1]:.4g} along the axis, in model units "
            f"from its start, but the crack goes from 0 to {depth:.4g}; change scale, start or radius so "
            "that the path covers the crack"
        )
    above = above - np.interp(0.0, along, above)
    centre = vector("centre", options.centre)
    reach = float(np.linalg.norm(box[1] - box[0]) + np.linalg.norm(centre - np.mean(box, axis=0)))
    inner = (along > -reach) & (along < depth)
    ends = np.array([min(-reach, along[0]), depth])
    at = np.concatenate([ends[:1], along[inner], ends[1:]])
    profile = np.stack([at, np.interp(at, along, above)], axis=1)
    frame = frame_of(options, sizes)
    sweep = frame[1] + np.tan(np.radians(options.slant)) * frame[2]
    lines = [centre + profile @ frame[[0, 2]] + side * reach * sweep for side in (-1, 1)]
    numbers: Numbers = {"path_points": int(inner.sum())}
    if len(along) > 2 and not ((along > 0) & (along < depth)).any():
        numbers["notes"] = [
            f"none of the path's {len(along)} points, from {along[0]:.4g} to {along[-1]:.4g}, is within "
            f"the crack, 0 to {depth:.4g}, so the crack is straight; check crack.scale"
        ]
    return GivenSurface(np.concatenate(lines), _strip(len(at))), numbers


def _strip(count: int) -> np.ndarray:
    """Return triangles between two lines of `count` points; the second line's ids follow the first's."""
    low = np.arange(count - 1)
    high = low + count
    return np.concatenate(
        [np.column_stack([low, low + 1, high + 1]), np.column_stack([low, high + 1, high])]
    )
