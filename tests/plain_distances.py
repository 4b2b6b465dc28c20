"""Distances of points from facets and edges, plainly, without the product's kernels."""

import numpy as np
from scipy.spatial import cKDTree


def nearest_on_segments(at, p, q) -> np.ndarray:
    """Return the nearest places (n, 3) to points `at` (n, 3) on the segments p-q (n, 3), one by one."""
    d = q - p
    t = ((at - p) * d).sum(axis=1) / np.maximum((d * d).sum(axis=1), 1e-300)
    return p + np.clip(t, 0, 1)[:, None] * d


def segment_distances(at, p, q) -> np.ndarray:
    """Return the (n,) distances of points from segments, one by one."""
    return np.linalg.norm(at - nearest_on_segments(at, p, q), axis=1)


def triangle_distances(at: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the (n,) distances of points `at` (n, 3) from triangles (n, 3, 3), one by one."""
    least = np.full(len(at), np.inf)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside = np.ones(len(at), bool)
    for i in range(3):
        p, q = corners[:, i], corners[:, (i + 1) % 3]
        least = np.minimum(least, segment_distances(at, p, q))
        inside &= (np.cross(q - p, at - p) * normal).sum(axis=1) >= 0
    length = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    height = np.abs(((at - corners[:, 0]) * normal).sum(axis=1)) / length
    return np.where(inside, np.minimum(least, height), least)


def _nearest(distances, at: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least distance of each point from cells (k, c, 3), and the nearest cell.

    No cell is nearer than its centre's distance less its radius, which leaves few to look at.
    """
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    reach = cKDTree(corners.reshape(-1, 3)).query(at)[0] + radius.max()
    around = cKDTree(centre).query_ball_point(at, reach * (1 + 1e-9))
    point = np.repeat(np.arange(len(at)), [len(cells) for cells in around])
    cell = np.concatenate([np.asarray(cells, np.int64) for cells in around])
    found = distances(at[point], corners[cell])
    order = np.lexsort((cell, found, point))
    first = order[np.searchsorted(point[order], np.arange(len(at)))]
    return found[first], cell[first]


def from_facets(at: np.ndarray, points: np.ndarray, facets: np.ndarray):
    """Return the distances of `at` from a facet set, and the nearest facet."""
    return _nearest(triangle_distances, at, points[facets])


def from_edges(at: np.ndarray, points: np.ndarray, edges: np.ndarray):
    """Return the distances of `at` from an edge set, and the nearest edge."""
    return _nearest(lambda at, ends: segment_distances(at, ends[:, 0], ends[:, 1]), at, points[edges])


def samples(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return corners, middles of edges and centroids of triangles or segments."""
    corners = points[cells]
    if cells.shape[1] == 2:
        return np.concatenate([points[np.unique(cells)], corners.mean(axis=1)])
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1)).reshape(-1, 3)
    return np.concatenate([points[np.unique(cells)], middles, corners.mean(axis=1)])
