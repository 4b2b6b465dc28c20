"""Fields around a crack tip in the crystals of a front, with derivatives along the local axes."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from craftmesh.fracture.segments import Stations
from craftmesh.mechanics.near_field import AXES_OF_FORCES, MODES
from craftmesh.mesh.front_curve import MovingFrames

# Powers of 1 / r in the gradients: three fields of unit K, two fields of unit forces.
POWERS = np.repeat([0.5, 1.0], [3, len(AXES_OF_FORCES)])[:, None]
# Lower bound of the stretch, a length along a curved front at some distance over the length at the front
# itself. It would be 0 at the centre of curvature.
LEAST_STRETCH = 0.05


class PointFields(NamedTuple):
    """The MODES fields at points (p,), in the local axes of each point: binormal, normal and tangent.

    h (p, 3, m, 3): derivative of displacement i along axis j in field m, at [:, i, m, j]; stress (p, m, 3,
    3); dh (p, 3, 3, m, 3), dstress (p, 3, m, 3, 3): their derivatives along each axis (index 1), including
    the turning of the axes along the front.
    """

    h: np.ndarray
    dh: np.ndarray
    stress: np.ndarray
    dstress: np.ndarray


def fields_at(
    stations: Stations,
    segment: int,
    s: np.ndarray,
    frames: MovingFrames,
    place: np.ndarray,
    side: np.ndarray,
) -> PointFields:
    """Return the near fields of the crystal of segment number `segment` at places (p, 3).

    s (p,) and frames: arc length and frames of the nearest points on the front; side (p,): 1 for points on
    the side of lip A, whose theta is within pi of pi / 2, and -1 on the side of lip B.
    """
    offset = (frames.axes @ (place - frames.point)[:, :, None])[:, :, 0]
    turn = frames.turns @ frames.axes.swapaxes(1, 2)
    stretch = np.maximum(frames.speed + (offset * turn[:, :, 2]).sum(axis=1), LEAST_STRETCH)
    x1, x2 = offset[:, 0], offset[:, 1]
    middle = 0.5 * np.pi * side
    theta = middle + np.mod(np.arctan2(x2, x1) - middle + np.pi, 2 * np.pi) - np.pi
    tables, stiffness = _interpolated(stations, segment, s, theta)
    r, x1, x2, b_n = (values[:, None, None, None] for values in (np.hypot(x1, x2), x1, x2, turn[:, 0, 1]))
    scale = r**-POWERS
    h, by_theta, by_s = (scale * table for table in tables)
    by_r, by_theta = -POWERS / r * h, by_theta / r
    cos, sin = x1 / r, x2 / r
    by_s -= b_n * r * by_theta
    by_s += (turn.swapaxes(1, 2) @ h.reshape(-1, 3, 3 * MODES)).reshape(h.shape)
    by_s += (h.reshape(-1, 3 * MODES, 3) @ turn).reshape(h.shape)
    by_s /= stretch[:, None, None, None]
    dh = np.stack([cos * by_r - sin * by_theta, sin * by_r + cos * by_theta, by_s], axis=1)
    return PointFields(h, dh, stresses(stiffness, h.swapaxes(1, 2)), stresses(stiffness, dh.swapaxes(2, 3)))


def stresses(stiffness: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    """Return the stresses (p, ..., 3, 3) of displacement gradients of the same shape.

    stiffness (p, 9, 9): over the nine components of a tensor, row by row.
    """
    rows = gradient.reshape(len(gradient), -1, 9)
    return (rows @ stiffness).reshape(gradient.shape)


def _interpolated(
    stations: Stations, segment: int, s: np.ndarray, theta: np.ndarray
) -> tuple[list[np.ndarray], np.ndarray]:
    """Return near fields' displacement gradients without their power of r, and the stiffness (p, 9, 9).

    The gradients are three arrays (p, 3, m, 3) at p points: values, derivatives by theta and derivatives by
    s. Their axes are point, displacement component, mode (m MODES) and direction of differentiation. They
    are interpolated by cubics in theta and linearly in s, the arc length of the segment, between stations.
    """
    station, part, per_s = stations.places(segment, s)
    angles = stations.angles
    cell, cells = angles[1] - angles[0], len(angles) - 1
    place = (theta - angles[0]) / cell
    k = np.clip(place.astype(np.int64), 0, cells - 1)
    y = place - k
    w = 1 - y
    # weights of the value and slope before the place, then of the value and slope after it
    weight = (1 + 2 * y) * w * w, y * w * w * cell, y * y * (3 - 2 * y), -y * y * w * cell
    rise = -6 * y * w / cell, w * (1 - 3 * y), 6 * y * w / cell, y * (3 * y - 2)
    here = 2 * (station * (cells + 1) + k)[:, None] + np.arange(4)
    column = np.concatenate([here, here + 2 * (cells + 1)], axis=1)
    first = np.arange(0, column.size + 1, 8)

    def summed(weights: tuple[np.ndarray, ...], before: np.ndarray, after: np.ndarray) -> np.ndarray:
        own = np.stack(weights, axis=1)
        data = np.concatenate([before[:, None] * own, after[:, None] * own], axis=1)
        shape = len(s), len(stations.gradients)
        rows = csr_array((data.ravel(), column.ravel(), first), shape)
        return (rows @ stations.gradients).reshape(-1, 3, MODES, 3)

    found = [summed(weight, 1 - part, part), summed(rise, 1 - part, part), summed(weight, -per_s, per_s)]
    before, after = stations.stiffness[station], stations.stiffness[station + 1]
    return found, before + part[:, None, None] * (after - before)
