"""The nearest point on a front's curve, and the frame there with its derivatives."""

from typing import NamedTuple

import numpy as np

from craftmesh.jit import kernel

# Rows of a frame (8, 3): the point, binormal, normal and tangent, their derivatives by s, and the length of
# the point's derivative.
POINT, AXES, TURNS, SPEED = 0, 1, 4, 7
NEWTON_STEPS = 12
# No step is longer than so many pieces of the curve.
LONGEST_STEP = 0.5


class Curve(NamedTuple):
    """The arrays of a FrontCurve: breaks (m + 1,), point and normal (m, 4, 3), closed."""

    breaks: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    closed: bool


@kernel
def fill_frame(curve, s, frame):
    """Fill `frame` (8, 3) at s; an open curve goes on straight beyond its ends, with the frames there."""
    length = curve.breaks[-1]
    beyond = 0.0
    if curve.closed:
        s = s % length
    elif s < 0.0 or s > length:
        end = 0.0 if s < 0.0 else length
        beyond, s = s - end, end
    piece = min(max(np.searchsorted(curve.breaks, s, side="right") - 1, 0), len(curve.point) - 1)
    x = s - curve.breaks[piece]
    first, second = frame[TURNS], frame[TURNS + 1]  # of the point for the time being
    _values(curve.point[piece], x, frame[POINT], first, second)
    slope = frame[SPEED]
    _values(curve.normal[piece], x, frame[AXES + 1], slope, frame[TURNS + 2])
    _turn(frame)
    if beyond != 0.0:
        for i in range(3):
            frame[POINT, i] += beyond * frame[SPEED, 0] * frame[AXES + 2, i]
            for k in range(3):
                frame[TURNS + k, i] = 0.0


@kernel
def _values(c, x, value, first, second):
    for i in range(3):
        value[i] = c[0, i] + x * (c[1, i] + x * (c[2, i] + x * c[3, i]))
        first[i] = c[1, i] + x * (2.0 * c[2, i] + 3.0 * x * c[3, i])
        second[i] = 2.0 * c[2, i] + 6.0 * x * c[3, i]


@kernel
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def _turn(frame):
    """Make the frame of the derivatives that stand in it: of the point in TURNS, of the normal in SPEED."""
    first, second, raw, raw_slope = frame[4].copy(), frame[5].copy(), frame[2].copy(), frame[7].copy()
    speed = np.sqrt(_dot(first, first))
    t = first / speed
    t_turn = (second - t * _dot(t, second)) / speed
    along = _dot(raw, t)
    n = raw - t * along
    n_turn = raw_slope - t_turn * along - t * (_dot(raw_slope, t) + _dot(raw, t_turn))
    size = np.sqrt(_dot(n, n))
    n /= size
    n_turn = (n_turn - n * _dot(n, n_turn)) / size
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        frame[1, i] = t[j] * n[k] - t[k] * n[j]
        frame[2, i] = n[i]
        frame[3, i] = t[i]
        frame[4, i] = t_turn[j] * n[k] - t_turn[k] * n[j] + t[j] * n_turn[k] - t[k] * n_turn[j]
        frame[5, i] = n_turn[i]
        frame[6, i] = t_turn[i]
        frame[7, i] = speed


@kernel
def nearest(curve, x, s, frame):
    """Return the s of the point on the curve nearest to x (3,), from a guess, and fill the frame there."""
    pieces = len(curve.point)
    length = curve.breaks[-1]
    longest = LONGEST_STEP * length / pieces
    for _ in range(NEWTON_STEPS):
        fill_frame(curve, s, frame)
        along = 0.0
        bend = 0.0
        for i in range(3):
            offset = frame[POINT, i] - x[i]
            along += offset * frame[AXES + 2, i]
            bend += offset * frame[TURNS + 2, i]
        speed = frame[SPEED, 0]
        step = along / max(speed + bend, 0.2 * speed)
        s -= min(max(step, -longest), longest)
        if abs(step) < 1e-12 * length:
            break
    fill_frame(curve, s, frame)
    return s % length if curve.closed else s


@kernel
def nearest_points(curve, points, guesses, s, distances, binormals):
    """Fill s, distances (k,) and binormals (k, 3) of the nearest points on the curve to points (k, 3)."""
    frame = np.zeros((8, 3))
    for k in range(len(points)):
        s[k] = nearest(curve, points[k], guesses[k], frame)
        d = points[k] - frame[POINT]
        distances[k] = np.hypot(_dot(d, frame[AXES]), _dot(d, frame[AXES + 1]))
        binormals[k] = frame[AXES]
