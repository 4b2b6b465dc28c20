"""The points of a cut surface on the crack front: where traces meet it, and points moved onto it."""

from dataclasses import replace

import numpy as np
import shapely

from craftmesh.errors import CraftmeshError
from craftmesh.insertion.cut import (
    CutSurface,
    SizeAt,
    feet_on_edges,
    flat_facets,
    split_edges,
    split_facet,
    trace_edges,
    with_phi,
)
from craftmesh.insertion.guarded_move import move_onto, settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import Sheet
from craftmesh.insertion.snap import LINE_SHARE, classified, leaves_crack
from craftmesh.surface.kernels.ranks import AT_JUNCTION, ON_LINE
from craftmesh.surface.measure import edge_lengths
from craftmesh.surface.rounding import ROUNDING, SAME_PLACE

# All chosen by hand. PIERCE_PASSES is the largest number of crossings of a trace edge with the front; each
# pass splits trace edges at their first crossing. TOUCHING and END limit how far a node may be from the
# given front and from its end.
PIERCE_PASSES = 12
TOUCHING = 1e-3  # distance, in local sizes, below which a trace point, crossing or corner is on the front
GRAZING = 0.05  # sine of the angle below which an edge between two front points does not cross the front
END = 0.3  # distance, in local sizes, below which a pierce point is the end of a front


def at_corners(surface: CutSurface, sheet: Sheet) -> CutSurface:
    """Return the surface with front points added at front corners in facets that lie in the crack.

    A corner is a sharp turn of the front. Without a node there, edges of such facets would cross the front
    near the corner again after each split.
    """
    for front in range(len(sheet.rim.curves)):
        for corner in sheet.rim.curves[front].at(sheet.rim.corners(front)):
            surface = _at_corner(surface, sheet, corner)
    return surface


def _at_corner(surface: CutSurface, sheet: Sheet, corner: np.ndarray) -> CutSurface:
    """Return the surface with a front point at `corner` (2,) if a facet in the crack contains it."""
    rows = flat_facets(surface)
    uv = sheet.uv(surface.points[surface.facets[rows].ravel()]).reshape(-1, 3, 2)
    within = np.flatnonzero(shapely.intersects_xy(shapely.polygons(uv), *corner))
    if not len(within):
        return surface
    row, place = int(rows[within[0]]), sheet.lift(corner[None])
    ids = surface.facets[row].astype(np.int64)
    edges = np.sort(np.column_stack([ids, np.roll(ids, -1)]), axis=1)
    to_points = np.linalg.norm(surface.points[ids] - place, axis=1)
    to_edges, _ = feet_on_edges(surface, edges, place)
    near, point = TOUCHING * surface.size[ids].mean(), np.array([len(surface.points)])
    if to_points.min() <= near:
        point = ids[[to_points.argmin()]]
    elif to_edges.min() <= near:
        edge = edges[[to_edges.argmin()]]
        surface = split_edges(surface, edge, place, surface.size[edge].mean(axis=1))
    else:
        surface = split_facet(surface, row, place)
    return with_front_points(surface, sheet, point)


def pierce(surface: CutSurface, sheet: Sheet) -> CutSurface:
    """Split trace edges where they meet the front; new points get phi = 0, front number and arc length.

    Raise CraftmeshError if PIERCE_PASSES passes do not suffice, because an edge crosses the front too
    often.
    """
    for _ in range(PIERCE_PASSES):
        surface = _touch(with_phi(surface, sheet), sheet)
        edges = trace_edges(surface)
        # only edges long enough to reach the front from both ends
        reach = np.abs(surface.phi[edges]).sum(axis=1)
        edges = edges[reach <= (1 + SAME_PLACE) * edge_lengths(surface.points, edges)]
        row, fraction = _first_crossing(surface, sheet, edges)
        if not len(row):
            return surface
        surface = _split_at_front(surface, sheet, edges[row], fraction)
    raise CraftmeshError(
        "the crack's line on a boundary crosses its front too often; smooth the front, or move the crack"
    )


def _touch(surface: CutSurface, sheet: Sheet) -> CutSurface:
    """Mark trace points within TOUCHING local sizes of the rim, the crack's boundary.

    At a front they become front points, at the mouth (where the crack leaves the body) points inside.

    Past the end of a front, the rim goes on to the mouth, which is pushed out of the box. A point that
    touches the rim there, near the end, counts as that end.
    """
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero((surface.front < 0) & (np.abs(surface.phi) <= TOUCHING * surface.size))
    at, size = sheet.uv(surface.points[rows]), surface.size[rows]
    foot, number, arc = sheet.rim.nearest_front(at)
    reach = np.where(_is_end(sheet, number, arc, TOUCHING * size), END, TOUCHING) * size
    on_front = np.linalg.norm(foot - at, axis=1) <= reach
    phi = surface.phi.copy()
    phi[rows[~on_front]] = TOUCHING * size[~on_front]
    surface, rows = replace(surface, phi=phi), rows[on_front]
    return with_front_points(surface, sheet, rows) if len(rows) else surface


def _is_end(sheet: Sheet, front: np.ndarray, arc: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of arc lengths within `near` (k,) of an end of their open front.

    front (k,): number of the front, -1 for none.
    """
    open_to = np.array([np.inf if curve.closed else curve.length for curve in sheet.rim.curves])
    length = np.append(open_to, np.inf)[front]
    return np.isfinite(length) & (np.minimum(arc, length - arc) <= near)


def with_front_points(surface: CutSurface, sheet: Sheet, rows: np.ndarray) -> CutSurface:
    """Return the surface with points `rows` (k,) marked as on the nearest front, without moving them.

    Marked points get phi = 0, the front's number and their arc length on it.
    """
    _, number, along = sheet.rim.nearest_front(sheet.uv(surface.points[rows]))
    phi, front, arc = surface.phi.copy(), surface.front.copy(), surface.arc.copy()
    phi[rows], front[rows], arc[rows] = 0.0, number, along
    return replace(surface, phi=phi, front=front, arc=arc)


def _first_crossing(surface: CutSurface, sheet: Sheet, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of edges (k, 2) that cross the front, and each first crossing's position, 0 to 1."""
    if not len(edges):
        return np.zeros(0, np.int64), np.zeros(0)
    at_end = _is_end(sheet, surface.front, surface.arc, _end_reach(sheet) * surface.size)[edges]
    row, fraction, at = _rim_crossings(surface, sheet, edges, at_end)
    size = surface.size[edges[row, 0]]
    off = np.linalg.norm(sheet.rim.nearest_front(at)[0] - at, axis=1)
    # What lies beyond the front's end is no front for an edge that meets the front or starts at its end, or
    # whose ends both lie outside the crack.
    meets = np.isin(row, row[off <= TOUCHING * size]) | at_end[row].any(axis=1)
    meets |= (surface.phi[edges[row]] < 0).all(axis=1)
    on_front = off <= np.where(meets, TOUCHING, _end_reach(sheet)) * size
    row, fraction = row[on_front], fraction[on_front]
    beside, share = _past_front_ends(surface, sheet, edges, row)
    row, fraction = np.concatenate([row, beside]), np.concatenate([fraction, share])
    order = np.lexsort([fraction, row])
    row, fraction = row[order], fraction[order]
    row, first = np.unique(row, return_index=True)
    return row, fraction[first]


def _end_reach(sheet: Sheet) -> float:
    """Return the largest distance, in local sizes, at which a trace may pass the front end where it ends.

    On the box the trace of a curved crack is a chord of the mouth, so it may pass at a distance.
    """
    return TOUCHING if sheet.planar else END


def _past_front_ends(
    surface: CutSurface, sheet: Sheet, edges: np.ndarray, crossed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of edges that leave the crack past a front end, and positions (0 to 1) on them there.

    Such an edge on the box is a chord of the mouth. Past the end of the front, it leaves through the part
    of the crack's domain that was extended out of the box. crossed (j,): rows that already cross the front.
    """
    ends = [curve.points[[0, -1]] for curve in sheet.rim.curves if not curve.closed]
    leaving = np.prod(np.sign(surface.phi[edges]), axis=1) < 0
    leaving[crossed] = False
    rows = np.flatnonzero(leaving)
    if not ends or not len(rows):
        return np.zeros(0, np.int64), np.zeros(0)
    lines = shapely.linestrings(sheet.uv(surface.points[edges[rows].ravel()]).reshape(-1, 2, 2))
    tree = shapely.STRtree(shapely.points(np.concatenate(ends)))
    end = tree.geometries[tree.query_nearest(lines, all_matches=False)[1]]
    near = shapely.distance(lines, end) <= END * surface.size[edges[rows, 0]]
    fraction = shapely.line_locate_point(lines, end, normalized=True)
    near &= (fraction > 0) & (fraction < 1)
    return rows[near], fraction[near]


def _rim_crossings(
    surface: CutSurface, sheet: Sheet, edges: np.ndarray, at_end: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the crossings of edges and rim: edge rows, positions (0 to 1) along edges, points in (u, v).

    Crossings at an end of the edge are dropped, and those at a sine below GRAZING of edges between two
    front points. at_end (k, 2): mask of edge ends that count as the end of a front; a crossing near such an
    end is that end, not a second crossing.
    """
    start, end = sheet.uv(surface.points[edges[:, 0]]), sheet.uv(surface.points[edges[:, 1]])
    row, segment = sheet.rim.tree.query(shapely.linestrings(np.stack([start, end], axis=1)), "intersects")
    a, d = start[row], end[row] - start[row]
    b, e = sheet.rim.segments[segment, 0], sheet.rim.segments[segment, 1] - sheet.rim.segments[segment, 0]
    cross = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    with np.errstate(all="ignore"):
        fraction = ((b - a)[:, 0] * e[:, 1] - (b - a)[:, 1] * e[:, 0]) / cross
    length, is_front = np.linalg.norm(d, axis=1), surface.front[edges[row]] >= 0
    margin = np.where(is_front, TOUCHING, ROUNDING)
    met = np.flatnonzero(np.isfinite(fraction) & at_end[row].any(axis=1))
    same_end = _at_same_end(surface, sheet, edges[row[met]], a[met] + fraction[met, None] * d[met])
    margin[met] = np.where(at_end[row[met]] & same_end, _end_reach(sheet), margin[met])
    margin *= surface.size[edges[row]]
    keep = np.isfinite(fraction) & (fraction * length > margin[:, 0])
    keep &= (1 - fraction) * length > margin[:, 1]
    keep &= ~is_front.all(axis=1) | (np.abs(cross) > GRAZING * length * np.linalg.norm(e, axis=1))
    return row[keep], fraction[keep], a[keep] + fraction[keep, None] * d[keep]


def _at_same_end(surface: CutSurface, sheet: Sheet, edges: np.ndarray, crossings: np.ndarray) -> np.ndarray:
    """Return a mask (k, 2) of ends of edges (k, 2) that are near the edge's crossing, along one front.

    crossings (k, 2): in u and v; near: within END local sizes. At a short mouth both ends of a front are
    near each other, and an edge from one of them may cross the front at the other.
    """
    _, number, arc = sheet.rim.nearest_front(crossings)
    along = np.abs(arc[:, None] - surface.arc[edges])
    same: np.ndarray = (number[:, None] == surface.front[edges]) & (along <= END * surface.size[edges])
    return same


def _split_at_front(
    surface: CutSurface, sheet: Sheet, edges: np.ndarray, fraction: np.ndarray
) -> CutSurface:
    start, end = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
    points = start + fraction[:, None] * (end - start)
    size = surface.size[edges]
    first = len(surface.points)
    surface = split_edges(surface, edges, points, size[:, 0] + fraction * (size[:, 1] - size[:, 0]))
    return with_front_points(surface, sheet, np.arange(first, len(surface.points)))


def snap_to_front(surface: CutSurface, sheet: Sheet, target: SizeAt, options: InsertOptions) -> CutSurface:
    """Move trace points near the front onto it, along the crack; those on the box go to the front's end.

    Trace points are where the crack meets a boundary. Near is within options.snap_front local sizes, less
    on a junction line, twice as far on the box; junction points inside the box stay. Points of an earlier
    crack stay if they would leave it.
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
    surface, moved = move_onto(surface, rows[chosen], targets[chosen], options.bounds)
    return with_front_points(surface, sheet, moved) if len(moved) else surface


def settle_front(surface: CutSurface, sheet: Sheet, options: InsertOptions) -> CutSurface:
    """Move front points that lie off the front onto it; the first and last on the box to the front's ends.

    A trace on a curved crack is a chord, so its crossing with the front in (u, v) lies off the crack.
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
    """Return ids (k,) of the first and last node on the box of each open front."""
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
    """Return for each point (n, 3) the nearest end of a front, exactly on the point's box planes.

    planes (n, 3): mask of the coordinates that box planes hold. NaN if that end is not on these planes.
    """
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
