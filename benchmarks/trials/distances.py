"""Distances from points to polylines and triangulated sheets, by plain formulas."""

import numpy as np
from scipy.spatial import cKDTree

NEAREST = 16  # triangles with the nearest centres, which are tried first


def told(place: np.ndarray) -> list[float]:
    """Return a place (3,) with the digits that find it again in a volume of any size."""
    return [float(f"{x:.6g}") for x in place]


def to_polylines(points: np.ndarray, polylines: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return the distance of each point (n, 3) from the nearest segment of polylines (k, 3)."""
    best = np.full(len(points), np.inf)
    for line in polylines:
        for start in range(0, len(line) - 1, 500):
            part = line[start : start + 501]
            best = np.minimum(best, to_segments(points, part[:-1], part[1:]))
    return best


def to_segments(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distance of each point (n, 3) from the nearest of the segments a-b (k, 3 each)."""
    best = np.full(len(points), np.inf)
    for first in range(0, len(points), 2000):
        block = points[first : first + 2000]
        best[first : first + 2000] = to_each_segment(block, a, b).min(axis=1, initial=np.inf)
    return best


def to_each_segment(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distances (n, k) of points (n, 3) from the segments a-b (k, 3 each)."""
    step = b - a
    square = np.maximum((step**2).sum(axis=1), 1e-300)
    t = np.clip(np.einsum("nkj,kj->nk", points[:, None] - a[None], step) / square, 0, 1)
    foot = a[None] + t[..., None] * step[None]
    return np.linalg.norm(points[:, None] - foot, axis=2)


def to_sheet(points: np.ndarray, corners: np.ndarray, enough: float) -> np.ndarray:
    """Return the distance of each point (n, 3) from triangles (m, 3, 3); under `enough` at most it.

    The triangles of the nearest centres are tried first, all others only where these leave more than
    `enough`, so that a distance under it may come out too large, but not over it.
    """
    if not len(points):
        return np.zeros(0)
    count = min(NEAREST, len(corners))
    near = cKDTree(corners.mean(axis=1)).query(points, k=count)[1].reshape(len(points), count)
    best = np.full(len(points), np.inf)
    for column in near.T:
        best = np.minimum(best, pair_distance(points, corners[column]))
    for row in np.flatnonzero(best > enough):
        low, high = corners.min(axis=1) - best[row], corners.max(axis=1) + best[row]
        some = ((points[row] >= low) & (points[row] <= high)).all(axis=1)
        all_of_it = np.broadcast_to(points[row], (int(some.sum()), 3))
        best[row] = pair_distance(all_of_it, corners[some]).min(initial=best[row])
    return best


def pair_distance(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the distance of point i (n, 3) from triangle i (n, 3, 3)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    inside = np.ones(len(points), bool)
    best = np.full(len(points), np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        step = q - p
        inside &= np.einsum("ij,ij->i", np.cross(step, points - p), normal) >= 0
        t = np.einsum("ij,ij->i", points - p, step) / np.maximum((step**2).sum(axis=1), 1e-300)
        foot = p + np.clip(t, 0, 1)[:, None] * step
        best = np.minimum(best, np.linalg.norm(points - foot, axis=1))
    height = np.abs(np.einsum("ij,ij->i", points - a, normal)) / size
    return np.where(inside, np.minimum(best, height), best)


def area_within(corners: np.ndarray, box: np.ndarray) -> float:
    """Return the area of the parts of triangles (m, 3, 3) that lie in the box (2, 3)."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    whole = (low >= box[0]).all(axis=1) & (high <= box[1]).all(axis=1)
    part = ~whole & (high > box[0]).all(axis=1) & (low < box[1]).all(axis=1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.linalg.norm(cross[whole], axis=1).sum() / 2
    return float(total + sum(_polygon_area(_clipped(triangle, box)) for triangle in corners[part]))


def _clipped(polygon: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return the part of a planar polygon (k, 3) in the box: one plane after another cuts it."""
    for axis in range(3):
        for bound, sign in ((box[0, axis], 1), (box[1, axis], -1)):
            if not len(polygon):
                return polygon
            depth = sign * (polygon[:, axis] - bound)
            kept = []
            for i, j in zip(range(len(polygon)), [*range(1, len(polygon)), 0]):
                if depth[i] >= 0:
                    kept.append(polygon[i])
                if (depth[i] >= 0) != (depth[j] >= 0):
                    kept.append(polygon[i] + depth[i] / (depth[i] - depth[j]) * (polygon[j] - polygon[i]))
            polygon = np.array(kept).reshape(-1, 3)
    return polygon


def _polygon_area(polygon: np.ndarray) -> float:
    if len(polygon) < 3:
        return 0.0
    spokes = polygon[1:] - polygon[0]
    return float(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0)) / 2)
