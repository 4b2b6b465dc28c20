"""The grain of each region of a crack patch: from the traces around it, else from where it lies."""

import numpy as np

from craftmesh.surface.connectivity import edge_sides, facet_edges, joined, unique_edges
from craftmesh.surface.labels import labels_at


def regions_of(triangles: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Return the region number (t,) of each patch triangle (t, 3): joined across edges not fixed (t, 3)."""
    _, of_corner, count = unique_edges(triangles)
    a, b = edge_sides(of_corner, count > 1)
    free = ~fixed.ravel()[a]
    return joined(len(triangles), a[free] // 3, b[free] // 3)


def labels_of_regions(
    points: np.ndarray, triangles: np.ndarray, region: np.ndarray, facets: np.ndarray, sides: np.ndarray
) -> np.ndarray:
    """Return the label (r,) of each region (t,) of the triangles (t, 3), from facets and sides (m, 2).

    At each trace edge the facet next to the patch around the edge tells the label on its side; the
    region takes what most of its edge length tells, one without a trace the label of most of its places.
    """
    count = int(region.max()) + 1
    owner, label, weight = _votes(points, triangles, region, facets, sides)
    labels = np.zeros(count, np.int64)
    known = np.zeros(count, bool)
    if len(owner):
        names, index = np.unique(label, return_inverse=True)
        tally = np.zeros((count, len(names)))
        np.add.at(tally, (owner, index), weight)
        known = tally.max(axis=1) > 0
        labels[known] = names[np.argmax(tally[known], axis=1)]
    for lost in np.flatnonzero(~known).tolist():
        centres = points[triangles[region == lost]].mean(axis=1)
        found, times = np.unique(labels_at(centres, points, facets, sides), return_counts=True)
        labels[lost] = found[times.argmax()]
    return labels


def _votes(
    points: np.ndarray, triangles: np.ndarray, region: np.ndarray, facets: np.ndarray, sides: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return region, label and weight for every patch triangle that has facets on one of its edges."""
    stride = np.int64(len(points) + 1)
    mine, theirs = facet_edges(triangles), facet_edges(facets)
    on_patch = np.zeros(len(points), bool)
    on_patch[triangles] = True
    near = np.flatnonzero(on_patch[theirs].all(axis=1))
    key_mine = mine.min(axis=1) * stride + mine.max(axis=1)
    key_theirs = theirs[near].min(axis=1) * stride + theirs[near].max(axis=1)
    order = np.argsort(key_theirs, kind="stable")
    near, key_theirs = near[order], key_theirs[order]
    begin, end = np.searchsorted(key_theirs, key_mine), np.searchsorted(key_theirs, key_mine, side="right")
    rows = np.repeat(np.arange(len(mine)), end - begin)
    offset = np.arange(len(rows)) - np.repeat(np.cumsum(end - begin) - (end - begin), end - begin)
    wing = near[begin[rows] + offset]
    angle, same_way = _angle_around(points, mine, triangles, rows, theirs, wing, facets)
    order = np.lexsort([angle, rows])
    rows, wing, angle, same_way = rows[order], wing[order], angle[order], same_way[order]
    first = np.concatenate([[True], rows[1:] != rows[:-1]]) if len(rows) else np.zeros(0, bool)
    rows, wing, angle, same_way = rows[first], wing[first], angle[first], same_way[first]
    # Turning from the patch about its edge, a facet that runs along the edge the same way as the patch
    # is met from behind, any other from ahead.
    label = np.where(same_way, sides[wing // 3, 0], sides[wing // 3, 1])
    length = np.linalg.norm(points[mine[rows, 1]] - points[mine[rows, 0]], axis=1)
    return region[rows // 3], label, length * np.minimum(np.abs(np.sin(angle)) + 1e-3, 1)


def _angle_around(
    points: np.ndarray,
    mine: np.ndarray,
    triangles: np.ndarray,
    rows: np.ndarray,
    theirs: np.ndarray,
    wing: np.ndarray,
    facets: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the angle 0..2 pi from patch triangle to facet about their edge, and if both run alike."""
    a, b = mine[rows, 0], mine[rows, 1]
    axis = points[b] - points[a]
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    apex = triangles[rows // 3, (rows % 3 + 2) % 3]
    across = facets[wing // 3, (wing % 3 + 2) % 3]
    x = _perpendicular(points[apex] - points[a], axis)
    y = np.cross(axis, x)
    d = points[across] - points[a]
    angle = np.arctan2(np.einsum("ij,ij->i", d, y), np.einsum("ij,ij->i", d, x))
    return np.where(angle < -1e-9, angle + 2 * np.pi, np.maximum(angle, 0.0)), theirs[wing, 0] == a


def _perpendicular(vectors: np.ndarray, axis: np.ndarray) -> np.ndarray:
    vectors = vectors - np.einsum("ij,ij->i", vectors, axis)[:, None] * axis
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)[:, None]
