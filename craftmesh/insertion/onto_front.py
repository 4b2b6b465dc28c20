"""Move points of a surface onto the front of a crack where that leaves the surface sound."""

import numpy as np

from craftmesh.insertion.cut import CutSurface, SizeAt
from craftmesh.insertion.guarded_move import guarded_move, settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import with_front_points
from craftmesh.insertion.sheet import Sheet
from craftmesh.insertion.snap import LINE_SHARE, classified, leaves_crack
from craftmesh.surface.classification import AT_JUNCTION, ON_LINE
from craftmesh.surface.guarded_move import MoveBounds
from craftmesh.surface.rounding import SAME_PLACE


def snap_to_front(surface: CutSurface, sheet: Sheet, target: SizeAt, options: InsertOptions) -> CutSurface:
    """Move trace points near the front onto it, along the crack; box points to the front's end.

    Points of a crack that was inserted before stay where they would leave that.
    """
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero(
            (np.abs(surface.phi) < options.snap_front * surface.size) & (surface.front < 0)
        )
    if not len(rows) or not sheet.rim.curves:
        return surface
    classes = classified(surface)
    reach = options.snap_front * np.minimum(surface.size[rows], target(surface.points[rows]))
    reach[classes.rank[rows] == ON_LINE] *= LINE_SHARE
    reach[classes.rank[rows] == AT_JUNCTION] = 0.0
    foot, _, _ = sheet.rim.nearest_front(sheet.uv(surface.points[rows]))
    targets = sheet.lift(foot)
    on_box = np.flatnonzero(classes.held[rows].any(axis=1))
    targets[on_box] = _front_ends(surface.points[rows[on_box]], classes.held[rows[on_box]], sheet)
    reach[on_box] *= 2
    with np.errstate(invalid="ignore"):
        chosen = np.linalg.norm(targets - surface.points[rows], axis=1) < reach
        chosen &= ~leaves_crack(surface, rows, targets)
    bounds = MoveBounds(turn=options.max_turn)
    surface, moved = guarded_move(surface, rows[chosen], targets[chosen], bounds)
    return with_front_points(surface, sheet, moved) if len(moved) else surface


def settle_front(surface: CutSurface, sheet: Sheet, options: InsertOptions) -> CutSurface:
    """Move front points that lie off the front onto it, the first and last of a front to its ends.

    A trace on a curved crack is a chord, so that where it crosses the front in (u, v) it is off the crack.
    """
    planes = classified(surface).held
    rows = np.flatnonzero(surface.front >= 0)
    targets = sheet.lift(sheet.rim.nearest_front(sheet.uv(surface.points[rows]))[0])
    on_box = planes[rows].any(axis=1)
    targets[on_box] = np.nan
    ends = np.isin(rows, _outermost(surface, sheet, rows[on_box]))
    targets[ends] = _front_ends(surface.points[rows[ends]], planes[rows[ends]], sheet)
    step = np.linalg.norm(targets - surface.points[rows], axis=1)
    with np.errstate(invalid="ignore"):
        chosen = (step > 0) & (step < options.snap_front * surface.size[rows])
    return settled(surface, rows[chosen], targets[chosen], options)[0]


def _outermost(surface: CutSurface, sheet: Sheet, on_box: np.ndarray) -> np.ndarray:
    """Return which of the front points on the box are the first and last of their open fronts."""
    ends = []
    for front, curve in enumerate(sheet.rim.curves):
        if curve.closed:
            continue
        ids = surface.on_front(front)
        ids = ids[np.isin(ids, on_box)]
        if len(ids):
            ends += [ids[0], ids[-1]]
    return np.unique(np.array(ends, np.int64))


def _front_ends(points: np.ndarray, planes: np.ndarray, sheet: Sheet) -> np.ndarray:
    """Return the nearest end of a front on the box plane of each point; NaN where there is none."""
    ends = [curve.points[[0, -1]] for curve in sheet.rim.curves if not curve.closed]
    result = np.full(points.shape, np.nan)
    if not len(ends) or not len(points):
        return result
    places = sheet.lift(np.concatenate(ends))
    distance = np.linalg.norm(points[:, None] - places[None], axis=2)
    nearest = places[np.argmin(distance, axis=1)]
    off_plane = np.abs(np.where(planes, nearest - points, 0.0)).max(axis=1)
    good = off_plane <= SAME_PLACE * distance.max()
    result[good] = np.where(planes, points, nearest)[good]
    return result
