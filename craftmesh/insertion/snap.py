"""Move points of a surface onto a crack and its front where that leaves the surface sound."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from craftmesh.insertion.cut import CutSurface, SizeAt
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import with_front_points
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, facet_angles
from craftmesh.surface.patches import feature_edges, held_by_box
from craftmesh.types import Surface

FARTHEST = 0.5  # of the local size: points slide along their line by at most this much
GRAZING = 0.5  # points on lines that graze the crack move straight from this share of the distance
LINE_SHARE = 0.5  # points on junction lines move to the front from this share of the distance others do
LEAST_GAP = 0.55  # of the target size: pierce points nearer than this are pushed apart along the front
SWEEPS = 30  # that push crowded pierce points apart, at most
STEEP = 0.1  # least squared cosine between a box plane and the crack's normal for moves in that plane
CORRECTIONS = 8  # steps onto a curved crack along a fixed direction; nothing checks that they converge
IN_PLANE = 1e-6  # of the model: the end of a front this near a point's box plane lies in it
KEPT = 0.999  # of its least angle, that a facet flatter than LEAST_ANGLE has to keep
LEAST_ANGLE = 4.0  # degrees: a move may not leave a facet below this, unless it was worse before


def snap_to_crack(surface: CutSurface, sheet: Sheet, options: InsertOptions) -> CutSurface:
    """Move points near the crack onto it: free points straight, box points in their plane, lines along.

    Points of lines that graze the crack, so that the way along is too far, move straight from nearer by.
    Quadruple points and box corners stay. A move that turns, flattens or pierces a facet is left out.
    """
    with np.errstate(invalid="ignore"):
        close = (np.abs(surface.psi) < options.snap * surface.size) & (surface.psi != 0)
    rows = np.flatnonzero(close)
    if len(rows):
        rows = rows[sheet.rim.inside(sheet.uv(surface.points[rows])) > -surface.size[rows]]
    if not len(rows):
        return surface
    junctions, planes = _classes(surface)
    targets = np.full((len(surface.points), 3), np.nan)
    free = rows[junctions.degree[rows] == 0]
    targets[free] = _onto_crack(surface.points[free], planes[free], sheet)
    on_line = np.zeros(len(surface.points), bool)
    on_line[rows[junctions.degree[rows] == 2]] = True
    _along_lines(surface, junctions.edges, on_line, targets)
    step = np.linalg.norm(targets - surface.points, axis=1)
    with np.errstate(invalid="ignore"):
        grazing = on_line & ~(step < FARTHEST * surface.size)
        grazing &= np.abs(surface.psi) < GRAZING * options.snap * surface.size
    targets[grazing] = _onto_crack(surface.points[grazing], planes[grazing], sheet)
    step = np.linalg.norm(targets - surface.points, axis=1)
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero(step < FARTHEST * surface.size)
    points, moved = guarded_move(surface, rows, targets[rows], options)
    psi = surface.psi.copy()
    psi[moved] = 0.0
    return replace(surface, points=points, psi=psi)


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


def _onto_crack(points: np.ndarray, planes: np.ndarray, sheet: Sheet) -> np.ndarray:
    """Return the points moved onto the crack, in their box plane where they have one; NaN if hopeless."""
    direction = np.where(planes, 0.0, sheet.frame[2])
    square = np.einsum("ij,ij->i", direction, direction)
    result = np.full(points.shape, np.nan)
    rows = np.flatnonzero(square > STEEP)
    moved = points[rows]
    for _ in range(1 if sheet.planar else CORRECTIONS):
        moved = moved - (sheet.offset(moved) / square[rows])[:, None] * direction[rows]
    result[rows] = moved
    return result


def _along_lines(surface: CutSurface, edges: np.ndarray, on_line: np.ndarray, targets: np.ndarray) -> None:
    """Fill in where the junction edges of the marked points cross the crack."""
    psi = surface.psi[edges]
    crossing = np.sign(psi[:, 0]) * np.sign(psi[:, 1]) < 0
    for start, end in ((0, 1), (1, 0)):
        a, b = edges[crossing, start], edges[crossing, end]
        chosen = on_line[a]
        a, b = a[chosen], b[chosen]
        fraction = surface.psi[a] / (surface.psi[a] - surface.psi[b])
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


def guarded_move(
    surface: CutSurface, rows: np.ndarray, targets: np.ndarray, options: InsertOptions
) -> tuple[np.ndarray, np.ndarray]:
    """Move points `rows` (k,) to `targets` (k, 3) as far as no facet turns, flattens or pierces another.

    Returns the points and the rows that were moved. Where a facet objects, its longest move is undone.
    """
    position = np.full(len(surface.points), -1)
    position[rows] = np.arange(len(rows))
    facets = surface.facets[(position[surface.facets] >= 0).any(axis=1)]
    mover = position[facets]
    step = np.linalg.norm(targets - surface.points[rows], axis=1)
    active = np.ones(len(rows), bool)
    before = _shape(surface.points, facets)
    known = _pairs(surface, surface.points, rows)
    while True:
        points = _moved(surface.points, rows, targets, active)
        bad = mover[_worse(before, _shape(points, facets), options)]
        if not len(bad):
            after = _pairs(surface, points, rows)
            hit = after[~np.isin(after[:, 0] * len(surface.facets) + after[:, 1], _keys(known, surface))]
            bad = position[surface.facets[hit.ravel()]]
        undo = _longest(bad, step, active)
        if not len(undo):
            break
        active[undo] = False
    return points, rows[active]


def _longest(movers: np.ndarray, step: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Return, for each row of movers (k, 3), -1 for none, the active one with the longest step."""
    usable = (movers >= 0) & active[movers]
    movers, usable = movers[usable.any(axis=1)], usable[usable.any(axis=1)]
    choice = np.argmax(np.where(usable, step[movers], -1.0), axis=1)
    return np.unique(movers[np.arange(len(movers)), choice])


def _moved(points: np.ndarray, rows: np.ndarray, targets: np.ndarray, active: np.ndarray) -> np.ndarray:
    points = points.copy()
    points[rows[active]] = targets[active]
    return points


_Shape = tuple[np.ndarray, np.ndarray]


def _shape(points: np.ndarray, facets: np.ndarray) -> _Shape:
    """Return area vectors (m, 3) and least angles (m,) in degrees."""
    return area_vectors(points, facets), facet_angles(points, facets).min(axis=1)


def _worse(before: _Shape, after: _Shape, options: InsertOptions) -> np.ndarray:
    """Tell which facets turned too far or became too flat."""
    cosine = np.einsum("ij,ij->i", before[0], after[0])
    length = np.linalg.norm(before[0], axis=1) * np.linalg.norm(after[0], axis=1)
    turned = cosine < np.cos(np.radians(options.max_turn)) * length
    return turned | (after[1] < np.minimum(LEAST_ANGLE, KEPT * before[1]))


def _pairs(surface: CutSurface, points: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the intersecting pairs among the facets near the crack that may meet a moved facet."""
    with np.errstate(invalid="ignore"):
        near = np.abs(surface.psi) <= 2 * np.nanmax(surface.size)
    near[rows] = True
    band = np.flatnonzero(near[surface.facets].any(axis=1))
    return band[intersecting_pairs(points, surface.facets[band])]


def _keys(pairs: np.ndarray, surface: CutSurface) -> np.ndarray:
    return pairs[:, 0] * len(surface.facets) + pairs[:, 1]
