"""Cracks along grain boundaries that consist of the surface's facets: split at the front and marked."""

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.insertion.cut import CutSurface, split_edges, uncut
from craftmesh.surface.connectivity import compact, rows_among, unique_edges
from craftmesh.surface.measure import along_segments, meets_box
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import CRACK, INTERFACE, Crack, Surface


def inlaid(surface: Surface, crack: Crack) -> Surface | None:
    """Return the surface with its facets marked as the crack; None if the crack is not made of them.

    Such a crack, made by `crack_in_boundaries`, has points of the surface; every other point lies exactly
    on an edge, at most one per edge. Edges are split at these points, and nothing moves. Raise
    CraftmeshError if a triangle then is no facet, as in a crack of another surface.
    """
    points, triangles, _ = compact(crack.points, crack.triangles)
    reach = np.stack([points.min(axis=0), points.max(axis=0)])
    rows = np.flatnonzero((surface.kind == INTERFACE) & meets_box(surface.points[surface.facets], reach))
    ids = _known(points, surface.points, np.unique(surface.facets[rows]))
    new = np.flatnonzero(ids < 0)
    if len(new) == len(ids):
        return None
    edges, _, _ = unique_edges(surface.facets[rows])
    edge = _edges_of(points[new], surface.points, edges)
    if (edge < 0).any() or len(np.unique(edge)) < len(edge):
        return None
    cut = uncut(surface)
    if len(new):
        cut = split_edges(cut, edges[edge], points[new], np.full(len(new), np.nan))
    ids[new] = len(surface.points) + np.arange(len(new))
    return _named(cut, ids[triangles])


def _known(places: np.ndarray, points: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the ids among `rows` of the points that equal the places (k, 3) exactly, -1 for none."""
    ids = {tuple(place): row for row, place in zip(rows.tolist(), points[rows].tolist())}
    return np.array([ids.get(tuple(place), -1) for place in places.tolist()], np.int64)


def _edges_of(places: np.ndarray, points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the edge (k,) on which each of the places (k, 3) lies, -1 for none."""
    start, step = points[edges[:, 0]], points[edges[:, 1]] - points[edges[:, 0]]
    length = np.linalg.norm(step, axis=1)
    near = scipy.spatial.cKDTree(start + step / 2).query_ball_point(
        places, length.max() / 2 * (1 + ROUNDING)
    )
    found = np.full(len(places), -1)
    for number, rows in enumerate(near):
        along = along_segments(places[number], start[rows], step[rows])
        foot = start[rows] + along[:, None] * step[rows]
        off = np.linalg.norm(foot - places[number], axis=1) / length[rows]
        if len(rows) and off.min() <= ROUNDING:
            found[number] = rows[int(off.argmin())]
    return found


def _named(cut: CutSurface, triangles: np.ndarray) -> Surface:
    """Return the surface with facets that equal `triangles` (m, 3) marked as crack, oriented like these."""
    facets, sides, kind = cut.facets.astype(np.int64), cut.sides.copy(), cut.kind.copy()
    rows = rows_among(triangles, facets)
    if (rows < 0).any():
        place = rounded_values(cut.points[triangles[rows < 0][0]].mean(axis=0))
        raise CraftmeshError(
            f"the crack's facet near {place} is not a facet of the surface; make the crack again from the "
            "grain boundaries of this surface"
        )
    first = (facets[rows] == triangles[:, :1]).argmax(axis=1)
    second = facets[rows, (first + 1) % 3]
    turned = rows[second != triangles[:, 1]]
    facets[turned], sides[turned] = facets[turned][:, ::-1], sides[turned][:, ::-1]
    kind[rows] = CRACK
    return Surface(cut.points, facets.astype(np.int32), sides, kind)
