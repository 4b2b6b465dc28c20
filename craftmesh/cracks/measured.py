"""Cracks as they are measured: points with an ordered front, or fronts alone."""

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

PER_TRIANGLE = 2.0  # measured points a triangle where no spacing is given: four to each unknown height
ACROSS_FRONT = 40  # triangles along a front where nothing but fronts is given
MOST_TRIANGLES = 400_000  # a minute of one core


def crack_through_points(
    cloud: np.ndarray,
    fronts: Sequence[np.ndarray],
    box: np.ndarray,
    spacing: float | None = None,
    l_min: float | None = None,
) -> tuple[GivenSurface, Numbers]:
    """Return the surface within the fronts that is nearest to a measured cloud, and how far that is.

    cloud (n, 3), in any order; fronts: polylines (k, 3), closed where the last point is the first, or one
    open front that ends on the box (2, 3). The surface is a height over the plane of least squares, with
    edges of `spacing` (model units; None: two points a triangle), exact at the fronts' points. The report
    has the distances of the cloud from it, with a note where one is over the bound, l_min (None: the
    spacing) or three times the points' scatter. Raises CraftmeshError where their root mean square is, for
    points that fix no plane or are not where the front is, and as cracked_part does.
    """
    fronts = [finite(f"front {k}", front) for k, front in enumerate(fronts, 1)]
    cloud = finite("point cloud", cloud)
    refuse_other_place(cloud, fronts)
    surface, numbers = _spanned(cloud, fronts, fronts, box, spacing, cloud)
    bound = max(numbers["spacing"] if l_min is None else l_min, SCATTERS * scatter_of(cloud))
    return surface, within_bound(
        numbers,
        bound,
        f"{bound:.4g} (l_min, or {SCATTERS:g} times the points' scatter); expected points of one sheet "
        "that is a height over a plane: leave out those that are not, or give a shorter crack.spacing",
    )


def crack_through_fronts(
    fronts: Sequence[np.ndarray],
    box: np.ndarray,
    spacing: float | None = None,
    inside: Sequence[float] | None = None,
) -> tuple[GivenSurface, Numbers]:
    """Return the surface that spans the fronts (k, 3) of successive increments, up to the last.

    It goes through all their points, and between them as straight as it can: within the first, if that is
    closed, or from it to the box (2, 3): on the side of the point `inside`, or else on the smaller one. The
    rest as crack_through_points.
    """
    fronts = [finite(f"front {k}", front) for k, front in enumerate(fronts, 1)]
    witness = np.reshape(inside if inside is not None else [], (-1, 3))
    return _spanned(np.zeros((0, 3)), fronts, fronts[-1:], box, spacing, witness)


def _spanned(
    cloud: np.ndarray,
    fronts: Sequence[np.ndarray],
    bounding: Sequence[np.ndarray],
    box: np.ndarray,
    spacing: float | None,
    witnesses: np.ndarray,
) -> tuple[GivenSurface, Numbers]:
    """Return the surface through all fronts, nearest to the cloud, that the bounding ones bound.

    witnesses (j, 3): points on the cracked side of an open front, beside the fronts before it.
    """
    every, box = np.concatenate([cloud, *fronts]), np.asarray(box, float)
    plane = plane_of(every)
    witnesses = np.concatenate([witnesses, *fronts[: len(fronts) - len(bounding)]])
    polygon = cracked_part(bounding, plane, box, witnesses, plane.of(every)[:, 2])
    length = _spacing(polygon, plane.of(cloud), bounding)
    if len(cloud):
        refuse_step(plane.of(cloud), [plane.of(front) for front in fronts], length)
    spacing = length if spacing is None else spacing
    return height_surface(polygon, plane, fronts, cloud, spacing, box)


def _spacing(polygon: shapely.Polygon, measured: np.ndarray, fronts: Sequence[np.ndarray]) -> float:
    """Return the default length of the surface's edges."""
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
    """Return the surface over the polygon that goes through the fronts' points and near the cloud's.

    Points that almost lie in a plane of the box (2, 3) are put there. The report has the spacing, how many
    triangles there are and, with a cloud (n, 3), the points used and their distances.
    """
    if polygon.area > MOST_TRIANGLES / 2 * spacing**2:
        raise CraftmeshError(
            f"spacing is {spacing:.4g} for a crack of the area {polygon.area:.4g}; expected at least "
            f"{np.sqrt(2 * polygon.area / MOST_TRIANGLES):.4g}"
        )
    on_fronts = [plane.of(front) for front in fronts]
    given = np.concatenate([np.zeros((0, 2)), *(uvh[:, :2] for uvh in on_fronts)])
    uv, triangles = filled(polygon, given, spacing)
    measured = plane.of(cloud)
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
    """Return the plane of least squares through points (k, 3), its normal's largest component positive."""
    centre = points.mean(axis=0)
    _, extent, axes = np.linalg.svd(points - centre, full_matrices=False)
    if extent[1] <= ROUNDING * extent[0]:
        raise CraftmeshError(f"the crack's {len(points)} points lie on a line; expected a surface's")
    normal = axes[2] * np.sign(axes[2][np.argmax(np.abs(axes[2]))])
    return Plane(centre, frame_along(normal, axes[0]))


def finite(what: str, points: np.ndarray) -> np.ndarray:
    """Return three or more points (k, 3); raises CraftmeshError that says `what` they are."""
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 3 or not np.isfinite(points).all():
        raise CraftmeshError(
            f"the crack's {what} is an array {points.shape}; expected finite points (k, 3), three or more"
        )
    return points


def _heights_along(uv: np.ndarray, fronts: Sequence[np.ndarray]) -> np.ndarray:
    """Return the heights (n,) of the points (n, 2) that lie on a front (k, 3) in (u, v), else NaN."""
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
    """Return how far the measured points (k, 3) are from the surface, and how many lie beside it.

    All coordinates are u, v and height; a distance is the height's times the slope's cosine.
    """
    row, triangle, at = interpolation(places[:, :2], triangles, measured[:, :2])
    if not len(row):
        raise CraftmeshError("no point of the cloud is within the front; give both in the same units")
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
    """Return the surface that a measured path (k, 2) sweeps through the box (2, 3), as deep as asked for.

    path: x along the crack, ascending, and y out of its plane, one to options.scale model units. The place
    x = options.start lies at options.centre, x goes along the axis, y along the normal. The surface goes
    from there along the axis to the increment's depth, and the other way out of the box: along the path as
    far as that was measured, then level. It is ruled: its lines stand across the axis, turned about it by
    options.slant degrees, and its front is one of them. Raises CraftmeshError for a path that turns back or
    ends before the crack does.
    """
    along, above = np.asarray(path, float).T * options.scale
    along = along - options.start * options.scale
    back = np.flatnonzero(np.diff(along) <= 0)
    if len(back):
        raise CraftmeshError(
            f"the crack's path turns back after its point {back[0] + 1}, x = {path[back[0], 0]:g}; "
            "expected ascending x: sort the points, or leave out those in which it overhangs"
        )
    sizes = semi_axes(options, increment)
    depth = sizes[0]
    if not along[0] <= 0 < depth <= along[-1]:
        raise CraftmeshError(
            f"the crack's path goes from {along[0]:.4g} to {along[-1]:.4g} along the axis, in model units "
            f"from its start; expected it to hold the crack, 0 to {depth:.4g}: change scale, start or "
            "radius"
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
            f"the crack, 0 to {depth:.4g}: it is straight there; is crack.scale right?"
        ]
    return GivenSurface(np.concatenate(lines), _strip(len(at))), numbers


def _strip(count: int) -> np.ndarray:
    """Return the triangles between two lines of `count` points, the second's after the first's."""
    low = np.arange(count - 1)
    high = low + count
    return np.concatenate(
        [np.column_stack([low, low + 1, high + 1]), np.column_stack([low, high + 1, high])]
    )
