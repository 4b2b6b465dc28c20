"""A front as a smooth curve, with the crack's normal along it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.mesh.cubic_basis import graded_basis

# Number of edges on each side over which edge lengths are averaged: neighbours differ by up to 3 : 1.
WINDOW = 4
# Length of the curve's pieces in local sizes (mean lengths of nearby front edges), and the stiffness of the
# fit. Measured with nodes up to 0.01 of an edge off the given front and 0.3 to 1.5 edges apart: on a circle
# of 8 edges radius tangents err by at most 0.30 degrees, by 0.72 with pieces of 2 sizes; on half an open
# circle by 0.40. A stiffness of 1e-2 lowers the circle's error by 0.08 degrees, but flattens sharp bends:
# K_I at the sharp ends of an ellipse 2:1, of five edges radius, was 0.6 % low instead of 0.35.
PIECE, STIFFNESS = 3.0, 1e-3
# Largest ratio of a piece's length to the front's bend radius. At the sharp ends of an ellipse 25:6, of
# three edges radius, K_I erred by 0.95 % without this limit, by 0.73 % with it.
OF_BEND = 0.6
# Smallest length of a piece relative to that on a straight front; shorter ones fit the noise of nodes.
SHORTEST = 0.5
# Weight of an open front's ends against its other nodes: they lie on faces, and the curve ends there.
END_WEIGHT = 1e6
# Newton iterations for points on curves and in elements, and their longest step in pieces of the curve.
NEWTON_STEPS, LONGEST_STEP = 12, 0.5


class MovingFrames(NamedTuple):
    """Frames at points (k,) of a curve.

    point (k, 3); axes (k, 3, 3): rows binormal, normal and tangent; turns (k, 3, 3): derivatives of the
    axes by arc length s; speed (k,): length of the point's derivative by s, close to 1.
    """

    point: np.ndarray
    axes: np.ndarray
    turns: np.ndarray
    speed: np.ndarray


@dataclass(frozen=True, eq=False)
class FrontCurve:
    """A front by its arc length s: point and normal are piecewise cubics of s with three columns.

    normal: the crack's, not exactly of unit length or perpendicular to the curve; `frames` corrects both.
    An open curve continues straight beyond its ends, with the frames of the ends.
    """

    point: "scipy.interpolate.PPoly"
    normal: "scipy.interpolate.PPoly"
    closed: bool

    @property
    def length(self) -> float:
        """The front's length."""
        return float(self.point.x[-1])

    @property
    def pieces(self) -> int:
        """The number of cubic pieces."""
        return len(self.point.x) - 1

    def frames(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return points, tangents, normals and binormals (k, 3) at s (k,) on the curve."""
        found = self.moving_frames(s)
        return found.point, *found.axes[:, ::-1].swapaxes(0, 1)

    def moving_frames(self, s: np.ndarray) -> MovingFrames:
        """Return the frames at s (k,) with their derivatives."""
        point, tangent, bend, speed = self._course(s)
        inside = self._inside(s)
        raw, slope = self.normal(inside), self.normal(inside, 1)
        across = square_to(raw, tangent)
        size = np.maximum(np.linalg.norm(across, axis=1, keepdims=True), np.finfo(float).tiny)
        normal = across / size
        tilt = (slope * tangent).sum(axis=1, keepdims=True) + (raw * bend).sum(axis=1, keepdims=True)
        turn = slope - bend * (raw * tangent).sum(axis=1, keepdims=True) - tilt * tangent
        turn = square_to(turn / size, normal)
        axes = np.stack([np.cross(tangent, normal), normal, tangent], axis=1)
        turns = np.stack([np.cross(bend, normal) + np.cross(tangent, turn), turn, bend], axis=1)
        if not self.closed:
            turns[s != inside] = 0.0
        return MovingFrames(point, axes, turns, speed)

    def nearest(self, points: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """Return the arc lengths s (k,) of the curve's points nearest to points (k, 3).

        Newton's method from `guess` (k,), at most NEWTON_STEPS iterations. s may lie beyond an open curve.
        """
        s, left = np.array(guess, float), np.arange(len(points))
        longest = LONGEST_STEP * self.length / self.pieces
        for _ in range(NEWTON_STEPS):
            place, tangent, bend, speed = self._course(s[left])
            off = place - points[left]
            slowest = np.maximum(speed + (off * bend).sum(axis=1), 0.2 * speed)
            step = (off * tangent).sum(axis=1) / slowest
            s[left] -= step.clip(-longest, longest)
            left = left[np.abs(step) >= 1e-12 * self.length]
        return self._inside(s) if self.closed else s

    def bend_radius(self, s: np.ndarray) -> np.ndarray:
        """Return the bend radius (k,) at s (k,), from tangents 0.001 of the length on either side."""
        step = 1e-3 * self.length
        low, high = s - step, s + step
        if not self.closed:
            low, high = low.clip(0), high.clip(None, self.length)
        turn = np.linalg.norm(self._course(high)[1] - self._course(low)[1], axis=1)
        return (high - low) / np.maximum(turn, 1e-12)

    def _inside(self, s: np.ndarray) -> np.ndarray:
        return np.mod(s, self.length) if self.closed else np.clip(s, 0, self.length)

    def _course(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return points, unit tangents, their derivatives by s (k, 3) and speeds (k,) at arc lengths s."""
        inside = self._inside(s)
        first, second = self.point(inside, 1), self.point(inside, 2)
        beyond = np.zeros(len(s)) if self.closed else s - inside
        speed = np.linalg.norm(first, axis=1)
        tangent = first / speed[:, None]
        bend = square_to(second, tangent) / speed[:, None]
        place = self.point(inside) + beyond[:, None] * first
        return place, tangent, np.where(beyond[:, None] == 0, bend, 0.0), speed


def front_curve(points: np.ndarray, normals: np.ndarray, closed: bool) -> FrontCurve:
    """Return the smooth curve along a front's ordered nodes (k, 3), k > 1, with normals (k, 3)."""
    s, _ = arc_lengths(points, closed)
    sizes = local_sizes(points, closed)
    curve = _fitted(points, normals, closed, sizes)
    finer = sizes_at_bends(sizes, curve.bend_radius(s), OF_BEND / PIECE)
    return curve if (finer == sizes).all() else _fitted(points, normals, closed, finer)


def _fitted(points: np.ndarray, normals: np.ndarray, closed: bool, sizes: np.ndarray) -> FrontCurve:
    """Return the fitted curve with pieces of PIECE times the local sizes (k,)."""
    s, length = arc_lengths(points, closed)
    basis = graded_basis(s, sizes, length, closed, PIECE)
    weights = np.ones(len(s))
    if not closed:
        weights[[0, -1]] = END_WEIGHT
    found = basis.solve(basis.design(s), np.hstack([points, normals]), weights, STIFFNESS)
    return FrontCurve(basis.pieces(found[:, :3]), basis.pieces(found[:, 3:]), closed)


def sizes_at_bends(sizes: np.ndarray, bend: np.ndarray, share: float) -> np.ndarray:
    """Return sizes (k,) limited to `share` of the bend radius (k,), but at least SHORTEST of the given."""
    return np.clip(share * bend, SHORTEST * sizes, sizes)


def arc_lengths(points: np.ndarray, closed: bool) -> tuple[np.ndarray, float]:
    """Return the arc lengths (k,) of a polyline's points (k, 3) and its whole length."""
    steps = edge_lengths(points, closed)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    return s[: len(points)], float(s[-1])


def edge_lengths(points: np.ndarray, closed: bool) -> np.ndarray:
    """Return the lengths of a polyline's edges, with the closing edge if it is closed."""
    ahead = np.concatenate([points[1:], points[:1]]) if closed else points[1:]
    return np.linalg.norm(ahead - points[: len(ahead)], axis=1)


def ways_along(s: np.ndarray, others: np.ndarray, total: float, closed: bool) -> np.ndarray:
    """Return distances (k, m) along a front of length `total` from s (k,) to arc lengths `others` (m,).

    Around a closed front, the shorter of the two distances.
    """
    way = np.abs(s[:, None] - others)
    return np.minimum(way, np.abs(total - way)) if closed else way


def local_sizes(points: np.ndarray, closed: bool) -> np.ndarray:
    """Return for each front node (k,) the mean length of the WINDOW edges on either side of it.

    Near an end of an open front fewer edges count.
    """
    steps = edge_lengths(points, closed)
    k, n = np.arange(len(points)), len(steps)
    total = np.concatenate([[0.0], np.cumsum(np.tile(steps, 3) if closed else steps)])
    if closed:
        reach = min(WINDOW, n)
        return (total[n + k + reach] - total[n + k - reach]) / (2 * reach)
    first, last = np.maximum(k - WINDOW, 0), np.minimum(k + WINDOW, n)
    return (total[last] - total[first]) / (last - first)


def square_to(vectors: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return vectors (k, 3) without their parts along unit directions (k, 3)."""
    return vectors - (vectors * directions).sum(axis=1, keepdims=True) * directions


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return vectors (..., 3) scaled to length one; zeros stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
