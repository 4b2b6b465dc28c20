"""Move points of a surface onto a crack and its front where that leaves the surface sound."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from craftmesh.insertion.cut import CutSurface, SizeAt
from craftmesh.insertion.guarded_move import guarded_move
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import with_front_points
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.patches import feature_edges, held_by_box
from craftmesh.types import Surface

NEAR = 10.0  # of the local size: an offset from the steepest crack that may be a distance worth a look
FARTHEST = 0.5  # of the local size: points slide along their line by at most this much
GRAZING = 0.5  # points on lines that graze the crack move straight from this share of the distance
LINE_SHARE = 0.5  # points on junction lines move to the front from this share of the distance others do
LEAST_GAP = 0.55  # of the target size: pierce points nearer than this are pushed apart along the front
SWEEPS = 30  # that push crowded pierce points apart, at most
STEEP = 0.1  # least squared cosine between a box plane and the crack's normal for moves in that plane
STRETCHES = 8  # of each way along a point's direction, in which a change of psi's sign is looked for
ON_CRACK = 1e-6  # of the local size: a point farther off the crack does not count as on it
IN_PLANE = 1e-6  # of the model: the end of a front this near a point's box plane lies in it


def snap_to_crack(surface: CutSurface, sheet: Sheet, options: InsertOptions) -> CutSurface:
    """Move points near the crack onto it: free points straight, box points in their plane, lines along.

    Points of lines that graze the crack, so that the way along is too far, move straight from nearer by.
    Quadruple points and box corners stay. A move that turns, flattens or pierces a facet is left out.
    """
    distance = _distances(surface, sheet)
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero((distance < options.snap * surface.size) & (surface.psi != 0))
    if len(rows):
        rows = rows[sheet.rim.inside(sheet.uv(surface.points[rows])) > -surface.size[rows]]
    if not len(rows):
        return surface
    reach = FARTHEST * surface.size
    junctions, planes = _classes(surface)
    targets = np.full((len(surface.points), 3), np.nan)
    free = rows[junctions.degree[rows] == 0]
    targets[free] = onto_crack(surface.points[free], planes[free], sheet, reach[free])
    on_line = np.zeros(len(surface.points), bool)
    on_line[rows[junctions.degree[rows] == 2]] = True
    _along_lines(surface, sheet, junctions.edges, on_line, targets)
    step = np.linalg.norm(targets - surface.points, axis=1)
    with np.errstate(invalid="ignore"):
        grazing = on_line & ~(step < reach)
        grazing &= distance < GRAZING * options.snap * surface.size
    targets[grazing] = onto_crack(surface.points[grazing], planes[grazing], sheet, reach[grazing])
    step = np.linalg.norm(targets - surface.points, axis=1)
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero(step < reach)
    points, moved = guarded_move(surface, rows, targets[rows], options)
    psi = surface.psi.copy()
    psi[moved] = 0.0
    return replace(surface, points=points, psi=psi)


def _distances(surface: CutSurface, sheet: Sheet) -> np.ndarray:
    """Return how far the points (n,) are from the crack to first order, NaN far from it."""
    distance = np.abs(surface.psi)
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero(distance < NEAR * surface.size)
    distance[rows] /= np.linalg.norm(sheet.gradient(surface.points[rows]), axis=1)
    return distance


def snap_to_front(surface: CutSurface, sheet: Sheet, target: SizeAt, options: InsertOptions) -> CutSurface:
    """Move trace points near the front onto it, along the crack; box points to the front's end."""
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero(
            (np.abs(surface.phi) < options.snap_front * surface.size) & (surface.front < 0)
        )
    if not len(rows):
        return surface
    junctions, planes = _classes(surface)
    reach = options.snap_front * np.minimum(surface.size[rows], target(surface.points[rows]))
    reach[junctions.degree[rows] == 2] *= LINE_SHARE
    reach[junctions.degree[rows] > 2] = 0.0
    foot, _, _ = sheet.rim.nearest_front(sheet.uv(surface.points[rows]))
    targets = sheet.lift(foot)
    on_box = np.flatnonzero(planes[rows].any(axis=1))
    targets[on_box] = _front_ends(surface.points[rows[on_box]], planes[rows[on_box]], sheet)
    reach[on_box] *= 2
    with np.errstate(invalid="ignore"):
        chosen = np.linalg.norm(targets - surface.points[rows], axis=1) < reach
    return _moved_onto_front(surface, sheet, rows[chosen], targets[chosen], options)


def spread_front(surface: CutSurface, sheet: Sheet, target: SizeAt, options: InsertOptions) -> CutSurface:
    """Move pierce points that crowd apart along the front, as far as the surface stays sound."""
    shifts, on_fronts = [np.zeros(0)], [np.zeros(0, np.int64)]
    _, planes = _classes(surface)
    for front, curve in enumerate(sheet.rim.curves):
        ids = surface.on_front(front)
        if len(ids) < 2:
            continue
        period = curve[-1, 2] if sheet.rim.closed[front] else np.inf
        held = planes[ids].any(axis=1)
        on_fronts.append(ids)
        shifts.append(
            _pushed_apart(surface.arc[ids], LEAST_GAP * target(surface.points[ids]), held, period)
        )
    rows, shift = np.concatenate(on_fronts), np.concatenate(shifts)
    reach = options.snap_front * surface.size[rows]
    chosen = (np.abs(shift) > 1e-9 * reach) & (np.abs(shift) <= reach)
    rows, shift = rows[chosen], shift[chosen]
    if not len(rows):
        return surface
    targets = np.empty((len(rows), 3))
    for front in np.unique(surface.front[rows]).tolist():
        mine = surface.front[rows] == front
        targets[mine] = sheet.lift(sheet.rim.on_front(front, surface.arc[rows[mine]] + shift[mine]))
    return _moved_onto_front(surface, sheet, rows, targets, options)


def _moved_onto_front(
    surface: CutSurface, sheet: Sheet, rows: np.ndarray, targets: np.ndarray, options: InsertOptions
) -> CutSurface:
    """Return the surface with the points `rows` at `targets` (k, 3) on the front, where that is sound."""
    points, moved = guarded_move(surface, rows, targets, options)
    return with_front_points(replace(surface, points=points), sheet, moved) if len(moved) else surface


def snap_ends(surface: CutSurface, sheet: Sheet, options: InsertOptions) -> CutSurface:
    """Move the first and last pierce point of open fronts along the box to the front's exact end."""
    _, planes = _classes(surface)
    ends = []
    for front in np.flatnonzero(~np.array(sheet.rim.closed, bool)).tolist():
        ids = surface.on_front(front)
        ids = ids[planes[ids].any(axis=1)]
        if len(ids):
            ends += [ids[0], ids[-1]]
    rows = np.unique(np.array(ends, np.int64))
    targets = _front_ends(surface.points[rows], planes[rows], sheet)
    step = np.linalg.norm(targets - surface.points[rows], axis=1)
    with np.errstate(invalid="ignore"):
        chosen = (step > 0) & (step < options.snap_front * surface.size[rows])
    return _moved_onto_front(surface, sheet, rows[chosen], targets[chosen], options)


def _pushed_apart(arc: np.ndarray, least: np.ndarray, held: np.ndarray, period: float) -> np.ndarray:
    """Return shifts (n,) of ordered positions that open gaps below `least`; held positions stay."""
    place = arc.copy()
    closed = np.isfinite(period)
    for _ in range(SWEEPS):
        gap = np.diff(place, append=place[0] + period if closed else np.inf)
        lack = np.maximum((least + np.roll(least, -1)) / 2 - gap, 0.0)
        if not lack.any():
            break
        free, other = ~held, ~np.roll(held, -1)
        weight = free.astype(float) + other
        share = np.where(weight > 0, lack / np.maximum(weight, 1), 0.0)
        place -= share * free
        place += np.roll(share, 1) * free
    return place - arc


class _Junctions(NamedTuple):
    """Edges where patches meet (k, 2) and how many of them end at each point (n,)."""

    edges: np.ndarray
    degree: np.ndarray


def _classes(surface: CutSurface) -> tuple[_Junctions, np.ndarray]:
    """Return the junction edges near the crack and which points are on x, y, z box planes (n, 3)."""
    rows = np.flatnonzero(np.isfinite(surface.psi[surface.facets]).any(axis=1))
    near = Surface(surface.points, surface.facets[rows], surface.sides[rows], surface.kind[rows])
    lines = feature_edges(near).lines
    degree = np.bincount(lines.ravel(), minlength=len(near.points))
    return _Junctions(lines, degree), held_by_box(near)


def onto_crack(points: np.ndarray, planes: np.ndarray, sheet: Sheet, reach: np.ndarray) -> np.ndarray:
    """Return the points (n, 3) moved onto the crack, in their box planes (n, 3), by at most reach (n,).

    They move along the crack's normal as far as the planes leave it; NaN where it is too steep to them, or
    where no place on the crack within ON_CRACK of the reach is found.
    """
    gradient = sheet.gradient(points)
    direction = np.where(planes, 0.0, gradient)
    square = np.einsum("ij,ij->i", direction, direction)
    result = np.full(points.shape, np.nan)
    rows = np.flatnonzero(square > STEEP * np.einsum("ij,ij->i", gradient, gradient))
    points, square, direction = points[rows], square[rows], direction[rows]
    if sheet.planar:
        result[rows] = points - (sheet.offset(points) / square)[:, None] * direction
        return result
    direction = direction * (reach[rows] / np.sqrt(square))[:, None]
    start, end, found = _bracket(points, direction, sheet)
    fraction, off = sheet.crossings(start[found], end[found])
    places = start[found] + fraction[:, None] * (end[found] - start[found])
    good = np.abs(off) <= ON_CRACK * reach[rows[found]]
    result[rows[found][good]] = places[good]
    return result


def _bracket(
    points: np.ndarray, direction: np.ndarray, sheet: Sheet
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the ends (n, 3) of the nearest stretch of points +- direction on which psi changes sign.

    And which rows have one (n,) bool. psi need not fall evenly along a box plane that a curved crack
    crosses obliquely, so that a step of Newton's may lead anywhere.
    """
    share = np.linspace(-1, 1, 2 * STRETCHES + 1)
    places = points[:, None] + share[None, :, None] * direction[:, None]
    psi = sheet.offset(places.reshape(-1, 3)).reshape(places.shape[:2])
    changes = np.sign(psi[:, :-1]) * np.sign(psi[:, 1:]) <= 0
    far = np.where(changes, np.abs(share[:-1] + share[1:]), np.inf)
    nearest = np.argmin(far, axis=1)
    row = np.arange(len(points))
    return places[row, nearest], places[row, nearest + 1], np.isfinite(far[row, nearest])


def _along_lines(
    surface: CutSurface, sheet: Sheet, edges: np.ndarray, on_line: np.ndarray, targets: np.ndarray
) -> None:
    """Fill in where the junction edges of the marked points cross the crack."""
    psi = surface.psi[edges]
    crossing = np.sign(psi[:, 0]) * np.sign(psi[:, 1]) < 0
    for start, end in ((0, 1), (1, 0)):
        a, b = edges[crossing, start], edges[crossing, end]
        chosen = on_line[a]
        a, b = a[chosen], b[chosen]
        fraction, off = sheet.crossings(surface.points[a], surface.points[b])
        on = np.abs(off) <= ON_CRACK * surface.size[a]
        a, b, fraction = a[on], b[on], fraction[on]
        targets[a] = surface.points[a] + fraction[:, None] * (surface.points[b] - surface.points[a])


def _front_ends(points: np.ndarray, planes: np.ndarray, sheet: Sheet) -> np.ndarray:
    """Return the nearest end of a front on the box plane of each point; NaN where there is none."""
    ends = np.array(
        [c[i, :2] for c, closed in zip(sheet.rim.curves, sheet.rim.closed) if not closed for i in (0, -1)]
    )
    result = np.full(points.shape, np.nan)
    if not len(ends) or not len(points):
        return result
    ends = sheet.lift(ends)
    distance = np.linalg.norm(points[:, None] - ends[None], axis=2)
    nearest = ends[np.argmin(distance, axis=1)]
    off_plane = np.abs(np.where(planes, nearest - points, 0.0)).max(axis=1)
    good = off_plane <= IN_PLANE * distance.max()
    result[good] = np.where(planes, points, nearest)[good]
    return result
