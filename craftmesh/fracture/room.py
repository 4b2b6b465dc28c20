"""How wide the tube round a front may be."""

import numpy as np
from scipy.spatial import KDTree

from craftmesh.fracture.options import LEAST_RADIUS
from craftmesh.mesh.front_curve import FrontCurve, arc_lengths

# The tube ends before the front's centre of curvature.
OF_CURVATURE = 0.8
# Parts of one front are strangers where the way along it is so many times the distance: half round a circle
# it is 1.6 times.
STRANGERS = 2.5


def radii(
    fronts: list[np.ndarray], number: int, closed: bool, curve: FrontCurve, sizes: np.ndarray, radius: float
) -> np.ndarray:
    """Return the tube's radius (k,) at the nodes of front `number` among fronts of points (k, 3) each.

    sizes (k,): local sizes; radius: the wish, in them. It is less where the front bends or another one, or
    another part of this one, is near, but LEAST_RADIUS at least.
    """
    points = fronts[number]
    s, total = arc_lengths(points, closed)
    room = np.minimum(_to_others(fronts, number), _to_itself(points, s, total, closed)) - sizes
    room = np.minimum(room, OF_CURVATURE * curve.bend_radius(s))
    return np.clip(room, LEAST_RADIUS * sizes, radius * sizes)


def _to_others(fronts: list[np.ndarray], number: int) -> np.ndarray:
    others = [points for k, points in enumerate(fronts) if k != number]
    if not others:
        return np.full(len(fronts[number]), np.inf)
    return KDTree(np.concatenate(others)).query(fronts[number])[0]


def _to_itself(points: np.ndarray, s: np.ndarray, total: float, closed: bool) -> np.ndarray:
    result = np.full(len(points), np.inf)
    for k, point in enumerate(points):
        way = np.abs(s - s[k])
        way = np.minimum(way, total - way) if closed else way
        distance = np.linalg.norm(points - point, axis=1)
        result[k] = distance[way > STRANGERS * distance].min(initial=np.inf)
    return result
