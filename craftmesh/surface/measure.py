"""Areas, normals, angles, volumes and bounding boxes of triangle sets, and distances from them."""

from collections.abc import Mapping

import numpy as np
import scipy

from craftmesh.surface.kernels.distances import nearest_facets
from craftmesh.surface.kernels.facet_measures import angles_of, area_vectors_of, volumes_from
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import Surface

FLAT = 1e-10  # ratio of area to squared longest edge up to which a facet is degenerate


def area_vectors(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return (m, 3) vectors along the normals of facets (m, 3) on points (n, 3), as long as the areas."""
    return area_vectors_of(*_for_kernels(points, facets))


def _for_kernels(points: np.ndarray, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points and facets of the types that kernels are compiled for."""
    return np.require(points, float, ["C", "W"]), np.require(facets, np.int32, ["C", "W"])


def total_area(points: np.ndarray, facets: np.ndarray) -> float:
    """Return the area of all facets (m, 3) on points (n, 3)."""
    return float(np.linalg.norm(area_vectors(points, facets), axis=1).sum())


def edge_lengths(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the lengths (e,) of edges (e, 2) between points (n, 3)."""
    lengths: np.ndarray = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    return lengths


def mean_edges(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the mean length (n,) of the edges (e, 2) at each point (n, 3), 0 without any."""
    length = edge_lengths(points, edges)
    total = np.bincount(edges.ravel(), np.repeat(length, 2), len(points))
    return total / np.maximum(np.bincount(edges.ravel(), minlength=len(points)), 1)


def along_segments(places: np.ndarray, start: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return positions (...,), from 0 to 1, of the segments' points nearest to places (..., d).

    start (..., d): first points; step (..., d): vectors from start to end.
    """
    square = np.maximum(np.einsum("...i,...i->...", step, step), np.finfo(float).tiny)
    return np.clip(np.einsum("...i,...i->...", places - start, step) / square, 0, 1)


def unit_normals(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the unit normals (m, 3) of facets (m, 3); zero for facets without area."""
    vectors = area_vectors(points, facets)
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)


def point_normals(area: np.ndarray, facets: np.ndarray, count: int) -> np.ndarray:
    """Return the unit normal (count, 3) at each of `count` points, zero at points without a facet.

    It is along the sum of the area vectors of the point's facets. area (m, 3): area vectors of the facets.
    """
    normals = np.zeros((count, 3))
    for corner in facets.T:
        np.add.at(normals, corner, area)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)


def is_degenerate(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of facets (m, 3) whose area is at most FLAT times their longest edge squared."""
    corners = points[facets]
    longest = ((np.roll(corners, -1, axis=1) - corners) ** 2).sum(axis=2).max(axis=1)
    return np.linalg.norm(area_vectors(points, facets), axis=1) <= FLAT * longest


def meets_box(corners: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of triangles (m, 3, 3) whose bounding boxes meet a box (2, 3)."""
    return ((corners.min(axis=1) <= box[1]) & (corners.max(axis=1) >= box[0])).all(axis=1)


def facet_angles(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return corner angles (m, 3), in degrees, of facets (m, 3) on points (n, 3).

    A degenerate facet has angles of 0 or 180.
    """
    return angles_of(*_for_kernels(points, facets))


def numbered(sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the labels (k,) that occur in sides (m, 2), sorted, and indices (m, 2) into them.

    Tables indexed that way are only as large as the number of labels, however large the labels are.
    """
    starts = np.ones(len(sides), bool)
    starts[1:] = (sides[1:, 0] != sides[:-1, 0]) | (sides[1:, 1] != sides[:-1, 1])
    run = np.flatnonzero(starts)
    labels = np.unique(sides[run])
    place = np.searchsorted(labels, sides[run])
    return labels, np.repeat(place, np.diff(run, append=len(sides)), axis=0)


def swept_volumes(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return signed volumes (m,) between the points' mean and facets (m, 3), > 0 if the mean is behind."""
    centre = points.mean(axis=0) if len(points) else np.zeros(3)
    return volumes_from(centre, *_for_kernels(points, facets))


def side_volumes(points: np.ndarray, facets: np.ndarray, sides: np.ndarray) -> dict[int, float]:
    """Return the volume enclosed per label by the divergence theorem; label 0, the outside, is left out.

    points (n, 3); facets (m, 3); sides (m, 2): labels behind and ahead of each facet's normal.
    A facet's volume counts for the label behind it and against the label ahead of it, so a crack
    facet with one grain on both sides adds nothing.
    """
    labels, place = numbered(sides)
    volume = enclosed(points, facets, place, len(labels))
    return {int(k): float(v) for k, v in zip(labels, volume) if k}


def volumes_of(surface: Surface) -> dict[int, float]:
    """Return the volumes of a surface's grains k and voids -k, as `side_volumes` does."""
    return side_volumes(surface.points, surface.facets, surface.sides)


def enclosed(points: np.ndarray, facets: np.ndarray, place: np.ndarray, count: int) -> np.ndarray:
    """Return the volumes (count,) that labels enclose; place (m, 2): index of each facet's two labels."""
    swept = swept_volumes(points, facets)
    volumes: np.ndarray = np.bincount(place[:, 0], swept, count) - np.bincount(place[:, 1], swept, count)
    return volumes


def volume_drift(before: Mapping[int, float], after: Mapping[int, float]) -> dict[int, float]:
    """Return each label's relative change of volume from `before` to `after`.

    A label missing in `after` has a drift of -1; a label with volume 0 before has the drift 0.
    """
    return {k: after.get(k, 0.0) / volume - 1 if volume else 0.0 for k, volume in before.items()}


def worst_drift(before: Mapping[int, float], after: Mapping[int, float]) -> float:
    """Return the size of the largest `volume_drift`, 0 without labels."""
    return max(map(abs, volume_drift(before, after).values()), default=0.0)


def shortened(moves: np.ndarray, reach: np.ndarray | float) -> np.ndarray:
    """Return moves (n, 3) in their directions, none longer than reach (n,)."""
    size = np.maximum(np.linalg.norm(moves, axis=1), 1e-300)
    return moves * np.minimum(1.0, reach / size)[:, None]


def span_of(points: np.ndarray) -> np.ndarray:
    """Return the bounding box (2, d), smallest and largest coordinates, of points (..., d)."""
    columns = points.reshape(-1, points.shape[-1]).T  # one by one: numpy is slow along short rows
    return np.array([[column.min() for column in columns], [column.max() for column in columns]])


def nearest_facet(
    places: np.ndarray, points: np.ndarray, facets: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the facet (q,), among facets (f, 3) on points (n, 3), f >= 1, nearest to places (q, 3).

    Also return the distances (q,) to these facets, and on which side (q,) of the facet's plane a place
    lies: 1 ahead, -1 behind or in it.
    """
    corners = points[facets]
    centres = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1) * (1 + ROUNDING)
    places = np.ascontiguousarray(places)
    some = scipy.spatial.cKDTree(centres).query(places)[1]
    facet, distance2, side = nearest_facets(places, points, facets, some, centres, reach)
    return facet, np.sqrt(distance2), side
