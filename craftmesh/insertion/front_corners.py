"""Corners of a front within facets that lie in the crack: such facets get a point there."""

import numpy as np
import shapely

from craftmesh.insertion.crack_patch import flat_facets
from craftmesh.insertion.cut import CutSurface, split_edges, split_facet
from craftmesh.insertion.guarded_move import settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import TOUCHING, with_front_points
from craftmesh.insertion.sheet import Sheet
from craftmesh.insertion.snap import classes

NEAR_EDGE = 0.2  # of a facet's height: a corner this near an edge parts that edge, and not the facet
NEAR_POINT = 0.3  # of a facet's shortest edge: a corner this near a free point of it takes that point


def onto_corners(surface: CutSurface, sheet: Sheet, options: InsertOptions) -> CutSurface:
    """Return the surface with a front point at each corner of a front within facets in the crack.

    Without them edges of those facets go round a corner on and on: each that is split where it crosses the
    front leaves another that does. Where a point of a facet is near and free to move it goes there, else an
    edge near by or the facet itself is parted.
    """
    for front in range(len(sheet.rim.curves)):
        for corner in sheet.rim.on_front(front, sheet.rim.corners(front)):
            surface = _onto_corner(surface, sheet, corner, options)
    return surface


def _onto_corner(
    surface: CutSurface, sheet: Sheet, corner: np.ndarray, options: InsertOptions
) -> CutSurface:
    rows = flat_facets(surface)
    uv = sheet.uv(surface.points[surface.facets[rows]].reshape(-1, 3)).reshape(-1, 3, 2)
    within = np.flatnonzero(shapely.intersects_xy(shapely.polygons(uv), *corner))
    if not len(within):
        return surface
    row, uv, place = int(rows[within[0]]), uv[within[0]], sheet.lift(corner[None])
    corners = surface.facets[row].astype(np.int64)
    away = np.linalg.norm(uv - corner, axis=1)
    point = corners[[int(away.argmin())]]
    lines, held = _lines(surface)
    shortest = np.linalg.norm(uv - np.roll(uv, 1, axis=0), axis=1).min()
    if away.min() > TOUCHING * surface.size[point[0]]:
        led = None
        if away.min() < NEAR_POINT * shortest and surface.front[point[0]] < 0 and not held[point[0]]:
            led = _moved(surface, point, place, options)
        if led is None:
            point = np.array([len(surface.points)])
            led = _through_edge(surface, corners, (uv, corner), place, lines, options)
        surface = led or split_facet(surface, row, place)
    return with_front_points(surface, sheet, point)


def _lines(surface: CutSurface) -> tuple[set[tuple[int, int]], np.ndarray]:
    """Return the junction lines' edges, lower point first, and which points are on them or on the box."""
    junctions, planes = classes(surface)
    held = (junctions.degree > 0) | planes.any(axis=1)
    return set(map(tuple, np.sort(junctions.edges, axis=1).tolist())), held


def _moved(
    surface: CutSurface, point: np.ndarray, place: np.ndarray, options: InsertOptions
) -> CutSurface | None:
    """Return the surface with a point at a place (1, 3), None where that is unsound."""
    moved, left = settled(surface, point, place, options, at_last=False)
    return None if len(left) else moved


def _through_edge(
    surface: CutSurface,
    corners: np.ndarray,
    seen: tuple[np.ndarray, np.ndarray],
    place: np.ndarray,
    lines: set[tuple[int, int]],
    options: InsertOptions,
) -> CutSurface | None:
    """Return the surface with the edge nearest to a place parted there, None where that is unsound or far.

    corners (3,): of the facet with the place; seen: they (3, 2) and the place (2,) in (u, v).
    """
    uv, at = seen
    area = _area(*uv)
    shares = np.array([_area(at, uv[1], uv[2]), _area(uv[0], at, uv[2]), _area(uv[0], uv[1], at)]) / area
    beside = int(shares.argmin())
    edge = np.sort(np.delete(corners, beside))
    if shares[beside] >= NEAR_EDGE or tuple(edge.tolist()) in lines:
        return None
    start, step = surface.points[edge[0]], surface.points[edge[1]] - surface.points[edge[0]]
    along = float((place[0] - start) @ step / (step @ step))
    if not 0 < along < 1:
        return None
    foot = (start + along * step)[None]
    split = split_edges(surface, edge[None], foot, surface.size[edge].mean(keepdims=True))
    return _moved(split, np.array([len(surface.points)]), place, options)


def _area(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    (x, y), (v, w) = b - a, c - a
    return float(x * w - y * v)
