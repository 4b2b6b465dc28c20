"""Where each point of a front goes, made smooth along it."""

import numpy as np
from scipy.interpolate import BSpline
from scipy.signal import savgol_filter

from craftmesh.growth.options import GrowthOptions

# Spacing of the knots of the fit in front spacings. 4 follow a kink angle along an inclined penny of ten
# spacings' radius within its noise, as they do for the intensities themselves.
KNOTS = 4.0
# Weight of the coefficients' second differences beside the rows: holds the fit where a front has no rows,
# as across a void, and moves it by less than rounding elsewhere.
STIFFNESS = 1e-4
DEGREE = 3


def smoothed_moves(
    s: np.ndarray, moves: np.ndarray, length: float, closed: bool, at: np.ndarray, options: GrowthOptions
) -> np.ndarray:
    """Return the moves (k, 3) at arc lengths (k,) of a front, from those (n, 3) of its rows at s (n,).

    `length` is the front's. fit: least squares on cubic B-splines with knots KNOTS row spacings apart;
    savitzky_golay: a parabola in a window of rows (the paper, section 2); none: straight between the rows.
    """
    if options.smoothing == "fit":
        spacing = KNOTS * np.median(np.diff(s)) if len(s) > 1 else length
        return _fitted(s, moves, length, closed, spacing)(at)
    if options.smoothing == "savitzky_golay" and len(s) >= options.window:
        width = options.window // 2 * 2 + 1
        moves = savgol_filter(moves, width, 2, axis=0, mode="wrap" if closed else "interp")
    if closed:
        s, moves = np.concatenate([s - length, s, s + length]), np.concatenate([moves] * 3)
    return np.stack([np.interp(at, s, moves[:, k]) for k in range(3)], axis=1)


def _fitted(s: np.ndarray, values: np.ndarray, length: float, closed: bool, spacing: float) -> BSpline:
    """Return the cubic B-spline over [0, length] nearest to values (n, 3) at s (n,); periodic if closed."""
    pieces = max(round(length / spacing), 2 * DEGREE if closed else 1)
    knots = length / pieces * np.arange(-DEGREE, pieces + DEGREE + 1)
    matrix = BSpline.design_matrix(np.clip(s, 0, knots[-DEGREE - 1]), knots, DEGREE).toarray()
    if closed:
        matrix[:, :DEGREE] += matrix[:, -DEGREE:]
        matrix = matrix[:, :-DEGREE]
    count = matrix.shape[1]
    bend = np.diff(np.eye(count + 2 * closed), 2, axis=0)
    if closed:
        bend[:, :2] += bend[:, -2:]
        bend = bend[:, :-2]
    stack = np.concatenate([matrix, STIFFNESS * bend])
    right = np.concatenate([values, np.zeros((len(bend), 3))])
    weights = np.linalg.lstsq(stack, right, rcond=None)[0]
    return BSpline(knots, np.concatenate([weights, weights[:DEGREE]]) if closed else weights, DEGREE)
