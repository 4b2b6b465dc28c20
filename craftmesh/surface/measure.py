"""Areas, normals, angles and volumes of triangle sets."""

from collections.abc import Mapping

import numpy as np


def area_vectors(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return (m, 3) vectors along the normals of facets (m, 3) on points (n, 3), as long as the areas."""
    a = points[facets[:, 0]]
    u, v = points[facets[:, 1]] - a, points[facets[:, 2]] - a
    vectors = np.empty((len(facets), 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        vectors[:, i] = 0.5 * (u[:, j] * v[:, k] - u[:, k] * v[:, j])
    return vectors


def total_area(points: np.ndarray, facets: np.ndarray) -> float:
    """Return the area of all facets (m, 3) on points (n, 3)."""
    return float(np.linalg.norm(area_vectors(points, facets), axis=1).sum())


def mean_edges(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the mean length (n,) of the edges (e, 2) at each point (n, 3), 0 without any."""
    length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    total = np.bincount(edges.ravel(), np.repeat(length, 2), len(points))
    return total / np.maximum(np.bincount(edges.ravel(), minlength=len(points)), 1)


def unit_normals(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the unit normals (m, 3) of facets (m, 3); zero for facets without area."""
    vectors = area_vectors(points, facets)
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)


def meets_box(corners: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return which triangles (m, 3, 3) have bounds that meet a box (2, 3): (m,) bool, none missed."""
    return ((corners.min(axis=1) <= box[1]) & (corners.max(axis=1) >= box[0])).all(axis=1)


def facet_angles(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the (m, 3) corner angles in degrees of facets (m, 3) on points (n, 3).

    A degenerate facet has angles of 0 or 180.
    """
    corner = points[facets]
    angles = np.empty(facets.shape)
    for i in range(3):
        u = corner[:, (i + 1) % 3] - corner[:, i]
        v = corner[:, (i + 2) % 3] - corner[:, i]
        cross = np.linalg.norm(np.cross(u, v), axis=1)
        angles[:, i] = np.degrees(np.arctan2(cross, np.einsum("ij,ij->i", u, v)))
    return angles


def numbered(sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the labels (k,) that occur in sides (m, 2), sorted, and the place (m, 2) of each among them.

    Tables and keys by that place are as large as there are labels, however large these are.
    """
    differs = np.ones(len(sides), bool)
    differs[1:] = (sides[1:] != sides[:-1]).any(axis=1)
    labels = np.unique(sides[differs])
    return labels, np.searchsorted(labels, sides)


def side_volumes(points: np.ndarray, facets: np.ndarray, sides: np.ndarray) -> dict[int, float]:
    """Return the volume enclosed per label by the divergence theorem; label 0, the outside, is left out.

    points (n, 3); facets (m, 3); sides (m, 2): labels behind and ahead of each facet's normal.
    A facet's volume counts for the label behind it and against the label ahead of it, so a crack
    facet with one grain on both sides adds nothing.
    """
    centre = points.mean(axis=0) if len(points) else np.zeros(3)
    swept = np.einsum("ij,ij->i", points[facets[:, 0]] - centre, area_vectors(points, facets)) / 3
    labels, index = numbered(sides)
    volume = np.bincount(index[:, 0], swept, len(labels)) - np.bincount(index[:, 1], swept, len(labels))
    return {int(k): float(v) for k, v in zip(labels, volume) if k}


def volume_drift(before: Mapping[int, float], after: Mapping[int, float]) -> dict[int, float]:
    """Return how far each label's volume `after` is from that `before`, relative to the latter.

    A label that is gone drifts by -1; one that had no volume does not drift.
    """
    return {k: after.get(k, 0.0) / volume - 1 if volume else 0.0 for k, volume in before.items()}
