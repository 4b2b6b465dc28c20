"""Extensions along a front over a whole step: K falls where the front runs ahead, and rises where it lags.

A wave of the front's shape, of amplitude x and wave number k, lowers K at its crests by x K (|k| - c) / 2,
where c is the front's mean curvature. This is exact to first order for a straight front (Rice, J. Appl.
Mech. 52, 1985) and a penny (Gao & Rice, Int. J. Fract. 33, 1987). A step integrates this part of da/dN
exactly, and the rest by an exponential Runge-Kutta method (Cox & Matthews, J. Comput. Phys. 176, 2002). So
no wave overshoots the straight front, however long the step is.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.cracks.polyline import Polyline
from craftmesh.growth.grow import FINENESS, LEAST_ROWS, in_order, nearest_feet

SMALL = 1e-4  # argument below which the functions _phi1 and _phi2 are computed by their series
Gain = Callable[[np.ndarray], np.ndarray]


class FrontRows(NamedTuple):
    """Rows of one front, that is, its nodes with K, in order; row (k,): their ids, s (k,): arc lengths.

    length: of the front, from first to last row if it is open; curvature: mean curvature of the front,
    positive if it is convex ahead of the crack.
    """

    row: np.ndarray
    s: np.ndarray
    length: float
    closed: bool
    curvature: float


def rows_along(lines: Sequence[Polyline], points: np.ndarray, binormal: np.ndarray) -> list[FrontRows]:
    """Return the rows of each front that has at least LEAST_ROWS.

    lines: the crack's fronts; points, binormal (n, 3): of all rows, which belong to their nearest fronts.
    """
    nearest, arc, _ = nearest_feet(list(lines), points)
    found = []
    for line, (row, s) in zip(lines, in_order(nearest, arc, len(lines))):
        if len(row) < LEAST_ROWS:
            continue
        s = s - (0.0 if line.closed else s[0])
        length = line.length if line.closed else float(s[-1])
        ring = np.append(row, row[0]) if line.closed else row
        along = np.diff(points[ring], axis=0)
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
        turning = float((np.diff(binormal[ring], axis=0) * along).sum())
        found.append(FrontRows(row, s, length, line.closed, turning / length))
    return found


def over_step(rate: np.ndarray, power: float, step: float, fronts: Sequence[FrontRows]) -> np.ndarray:
    """Return the extensions (n,) of a step from the relative rates (n,) at its start.

    step: extension of a straight front with rate 1 everywhere; power: d ln(rate) / d ln(K), one number.
    Points with rate 0 stay.
    """
    relaxed = _with_gain(rate, fronts, lambda decay: _phi1(power * step * decay))
    return np.where(rate > 0, step * np.maximum(relaxed, 0.0), 0.0)


def over_step_again(
    rate: np.ndarray, extension: np.ndarray, reached: np.ndarray, power: float, fronts: Sequence[FrontRows]
) -> np.ndarray:
    """Return corrected extensions (n,) of a step from the rates (n,) at its start and `reached` at its end.

    extension (n,): the extensions at whose end the rates `reached` (n,) were found; power: d ln(rate) /
    d ln(K).
    """
    if not (rate > 0).any():
        return extension
    step = extension.sum() / rate.sum()
    share = extension / step
    change = reached - rate + _with_gain(share, fronts, lambda decay: power * step * decay)
    more = step * _with_gain(change, fronts, lambda decay: _phi2(power * step * decay))
    return np.where(extension > 0, np.maximum(extension + more, 0.0), 0.0)


def _with_gain(values: np.ndarray, fronts: Sequence[FrontRows], gain: Gain) -> np.ndarray:
    """Return values (n,) of rows after each wave of them along a front is multiplied by a factor.

    gain: returns the factors (m,) for decays (m,) of the waves; a decay is the loss of ln K at a crest per
    unit extension. Rows on none of the `fronts` are multiplied by the factor at decay 0.
    """
    result = np.full(len(values), np.nan)
    for front in fronts:
        period, s, own = front.length, front.s, values[front.row]
        if not front.closed:  # mirror the waves at the free faces
            period, s, own = 2 * period, np.append(s, 2 * period - s[::-1]), np.append(own, own[::-1])
        at = np.arange(FINENESS * len(s)) / (FINENESS * len(s)) * period
        decay = np.maximum(2 * np.pi / period * np.arange(len(at) // 2 + 1) - front.curvature, 0.0) / 2
        waves = scipy.fft.rfft(np.interp(at, s, own, period=period)) * (gain(decay) - 1)
        change = np.interp(front.s, at, scipy.fft.irfft(waves, len(at)), period=period)
        result[front.row] = values[front.row] + change
    mean = gain(np.zeros(1))[0]
    return np.where(np.isnan(result), mean * values, result)


def _phi1(z: np.ndarray) -> np.ndarray:
    """Return (1 - exp(-z)) / z."""
    return np.where(z > SMALL, -np.expm1(-z) / np.maximum(z, SMALL), 1 - z / 2)


def _phi2(z: np.ndarray) -> np.ndarray:
    """Return (exp(-z) - 1 + z) / z^2."""
    return np.where(z > SMALL, (np.expm1(-z) + z) / np.maximum(z, SMALL) ** 2, 0.5 - z / 6)
