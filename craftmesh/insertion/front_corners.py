"""Corners of a front within facets that lie in the crack, or on a trace of it: these get a point there."""

import numpy as np
import shapely

from craftmesh.insertion.crack_patch import flat_facets
from craftmesh.insertion.cut import CutSurface, feet_on_edges, split_edges, split_facet, trace_edges
from craftmesh.insertion.guarded_move import settled
from craftmesh.insertion.onto_front import LINE_SHARE
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import TOUCHING, with_front_points
from craftmesh.insertion.sheet import Sheet
from craftmesh.insertion.snap import classes

NEAR_EDGE = 0.2  # of a facet's height: a corner this near an edge parts that edge, and not the facet
# Of the local size: a corner this near a trace takes a point of that. A notch's corner 0.007 edges past one
# left 7 flat tets.
NEAR_TRACE = 0.1
NEAR_POINT = 0.3  # of a facet's shortest edge: a corner this near a free point of it takes that point


def onto_corners(surface: CutSurface, sheet: Sheet, options: InsertOptions) -> CutSurface:
    """Return the surface with points at the corners of fronts in facets in the crack, or on its traces.

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
        return _onto_trace(surface, sheet, sheet.lift(corner[None]), options)
    row, place = int(rows[within[0]]), sheet.lift(corner[None])
    at_point = _at_point(surface, row, place, options)
    if at_point is not None:
        surface, point = at_point
        return with_front_points(surface, sheet, point)
    point = np.array([len(surface.points)])
    parted = _through_edge(surface, row, place, options) or split_facet(surface, row, place)
    return with_front_points(parted, sheet, point)


def _onto_trace(surface: CutSurface, sheet: Sheet, place: np.ndarray, options: InsertOptions) -> CutSurface:
    """Return the surface with a front point on the trace edge that a corner, place (1, 3), lies on.

    An edge next to it has its end there, or a new point, moved to the corner where that is sound.
    """
    edges = np.sort(trace_edges(surface), axis=1)
    if not len(edges):
        return surface
    off, foot = feet_on_edges(surface, edges, place)
    nearest = int(off.argmin())
    edge, foot = edges[nearest], foot[[nearest]]
    size = surface.size[edge].mean(keepdims=True)
    touches = off[nearest] <= TOUCHING * size[0]
    reach = (TOUCHING if touches else NEAR_TRACE) * size[0]
    if not off[nearest] <= reach:
        return surface
    to_ends = np.linalg.norm(surface.points[edge] - place, axis=1)
    if to_ends.min() <= reach:
        parted, point = surface, edge[[int(to_ends.argmin())]]
    else:
        parted, point = split_edges(surface, edge[None], foot, size), np.array([len(surface.points)])
    if touches:
        return with_front_points(parted, sheet, point)
    moved = None if _is_held(parted, int(point[0])) else _moved(parted, point, place, options)
    return surface if moved is None else with_front_points(moved, sheet, point)


def _at_point(
    surface: CutSurface, row: int, place: np.ndarray, options: InsertOptions
) -> tuple[CutSurface, np.ndarray] | None:
    """Return the surface with a corner of a facet at the place (1, 3) near by, and that corner (1,).

    None where none is near, may move or is free to.
    """
    ids = surface.facets[row].astype(np.int64)
    corners = surface.points[ids]
    away = np.linalg.norm(corners - place, axis=1)
    nearest = int(away.argmin())
    point = ids[[nearest]]
    if away[nearest] <= TOUCHING * surface.size[point[0]]:
        return surface, point
    shortest = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).min()
    if _is_held(surface, int(point[0])) or away[nearest] > NEAR_POINT * shortest:
        return None
    moved = _moved(surface, point, place, options)
    return None if moved is None else (moved, point)


def _is_held(surface: CutSurface, point: int) -> bool:
    """Tell whether a point is on a line, on the box or on the front."""
    junctions, planes = classes(surface)
    return bool(junctions.degree[point] > 0 or planes[point].any() or surface.front[point] >= 0)


def _through_edge(
    surface: CutSurface, row: int, place: np.ndarray, options: InsertOptions
) -> CutSurface | None:
    """Return the surface with a facet's edge parted at the place (1, 3) near by; None where it is far.

    An edge with the place on it is parted there. The new point of another moves to the place: within reach
    of points on lines where it is on one, not if the box holds it, and where that is sound.
    """
    ids = surface.facets[row].astype(np.int64)
    edges = np.sort(np.column_stack([ids, np.roll(ids, -1)]), axis=1)
    off, feet = feet_on_edges(surface, edges, place)
    nearest = int(off.argmin())
    edge, foot, size = edges[nearest], feet[[nearest]], surface.size[edges[nearest]].mean(keepdims=True)
    parted = split_edges(surface, edge[None], foot, size)
    if off[nearest] <= TOUCHING * size[0]:
        return parted
    a, b, c = surface.points[ids]
    height = np.linalg.norm(np.cross(b - a, c - a)) / np.linalg.norm(np.subtract(*surface.points[edge]))
    if off[nearest] > NEAR_EDGE * height:
        return None
    junctions, planes = classes(surface)
    is_line = (np.sort(junctions.edges, axis=1) == edge).all(axis=1).any()
    reach = LINE_SHARE * options.snap_front * size[0]
    if planes[edge].all(axis=0).any() or (is_line and off[nearest] > reach):
        return None
    return _moved(parted, np.array([len(surface.points)]), place, options)


def _moved(
    surface: CutSurface, point: np.ndarray, place: np.ndarray, options: InsertOptions
) -> CutSurface | None:
    """Return the surface with a point at a place (1, 3), None where that is unsound."""
    moved, left = settled(surface, point, place, options, at_last=False)
    return None if len(left) else moved
