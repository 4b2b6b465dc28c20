"""Smooth the moves of a front's points along the front, and find the points that stay."""

import numpy as np
import scipy
from scipy.sparse import vstack

from craftmesh.cracks.polyline import Polyline
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.options import SmoothingOptions
from craftmesh.growth.trust import END, or_all
from craftmesh.mesh.cubic_basis import even_basis
from craftmesh.mesh.front_curve import square_to, unit, ways_along

# Knot spacing of the fit, in row spacings (a row is a front node with K). With 4 the fit follows the kink
# angle along an inclined penny with a radius of ten spacings within the angle's noise, and K too.
KNOTS = 4.0
# Smallest reach of the fit, in extensions; the fit halves waves of wave number 1 / reach. A front that is
# off its plane by a wave of wave number k turns back by k times its height per unit of extension (Movchan,
# Gao & Willis 1998; Poisson's ratio 0). So a step longer than 1 / k overshoots the plane; 3^(3/4) / 4 is
# the smallest value with which the fit lets no wave overshoot. The reach is also at least one row spacing:
# then the noise of rows at an end is doubled. With a sixth of a spacing it became twentyfold, which folded
# a crack whose kink angles jump by 10 degrees between grains.
OF_STEP = 0.57
# Integral of the square of a cubic B-spline with knot spacing 1.
MEAN_SQUARE = 151 / 315
# Distance of successive rows, in spacings, above which the front ends between them, for example at a void.
GAP = 3.0


def points_at_rest(line: Polyline, s: np.ndarray, goes: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of a front's points that stay.

    s, goes (n,): arc lengths of the front's rows, and mask of rows that move. A point stays if its nearest
    row stays, or if it is the nearest point of a row that stays.
    """
    way = ways_along(line.arc, s, line.length, line.closed)
    rest = ~goes[way.argmin(axis=1)]
    rest[way[:, ~goes].argmin(axis=0)] = True
    if line.closed:
        rest[[0, -1]] = rest[0] | rest[-1]
    return rest


def beside_rest(line: Polyline, rest: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return factors (k,) <= 1 on `moves` (k, 3): at most the way along the front to a point that stays.

    rest (k,): mask of points that stay. So the new front leaves the old one at 45 degrees at most. K and
    extension do not jump along a front, and elements at a sharper corner would be slivers.
    """
    room = ways_along(line.arc, line.arc[rest], line.length, line.closed).min(axis=1, initial=np.inf)
    size = np.linalg.norm(moves, axis=1)
    return np.minimum(1.0, room / np.maximum(size, np.finfo(float).tiny))


def moves_along(
    line: Polyline, s: np.ndarray, step: FrontStep, options: SmoothingOptions, coarser: float
) -> np.ndarray:
    """Return the moves (k, 3) of the points of a front `line` from its rows `step` at ascending s (n,).

    Rows that stay or are not trusted take kink angle and extension by linear interpolation between trusted
    rows that move. Kink angles, extensions and the normals and binormals of all rows are then `smoothed`,
    with `coarser` times the median extension as length. The normals need it too: at an end the crack's
    normal may be that of a single facet, turned by 40 degrees.
    """
    goes = step.extension > 0
    known = or_all(step.trusted, goes)
    values = np.column_stack([step.kink_angle, step.extension])[known]
    kink, extension = _straight_between(s[known], values, line.length, line.closed, s).T
    length = coarser * float(np.median(step.extension[goes]))
    rows = np.column_stack([kink, extension, step.normal, step.binormal])
    found = smoothed(s, rows, line.length, line.closed, line.arc, options, length)
    kink, extension = found[:, :2].T[:, :, None]
    normal, binormal = unit(found[:, 2:5]), unit(square_to(found[:, 5:], line.tangents()))
    return extension * unit(np.cos(kink) * binormal + np.sin(kink) * normal)


def smoothed(
    s: np.ndarray,
    values: np.ndarray,
    length: float,
    closed: bool,
    at: np.ndarray,
    options: SmoothingOptions,
    step: float = 0.0,
) -> np.ndarray:
    """Return values (k, m) at arc lengths `at` (k,) of a front, from row values (n, m) at s (n,).

    length: of the front. With smoothing fit, `_fitted` smooths over a row spacing or OF_STEP times the
    extension `step`, the larger; savitzky_golay fits a parabola in a window of rows (the paper, section 2),
    if there are enough rows; none interpolates linearly between rows.
    """
    if options.smoothing == "fit":
        spacing = float(np.median(np.diff(s))) if len(s) > 1 else length
        rows = _off_ends(s, length, closed, spacing)
        reach = max(spacing, OF_STEP * step)
        return _fitted(s[rows], values[rows], length, closed, at, KNOTS * spacing, reach)
    if options.smoothing == "savitzky_golay" and len(s) >= options.window:
        width = options.window // 2 * 2 + 1
        mode = "wrap" if closed else "interp"
        values = scipy.signal.savgol_filter(values, width, 2, axis=0, mode=mode)
    return _straight_between(s, values, length, closed, at)


def _fitted(
    s: np.ndarray,
    values: np.ndarray,
    length: float,
    closed: bool,
    at: np.ndarray,
    knots: float,
    reach: float,
) -> np.ndarray:
    """Return values (k, m) at arc lengths `at` (k,) of the smoothing spline for values (n, m) at s (n,).

    The fit minimizes squared residuals plus reach^4 times the squared second derivative. So a wave of wave
    number k keeps the fraction 1 / (1 + (k reach)^4), and an open front continues straight at its ends. The
    slope from end to end of an open front is penalized by reach^3 times its square, so that the front of a
    plate with few edges does not twist on noise. length: of the front; knots: knot spacing.
    """
    basis = even_basis(length, closed, knots)
    rows, weights = basis.design(s), np.ones(len(s))
    if not closed:
        trend = (basis.design(np.array([length])) - basis.design(np.zeros(1))) / length
        rows, values = vstack([rows, trend]), np.append(values, 0 * values[:1], axis=0)
        weights = np.append(weights, reach**3 * KNOTS / knots)
    gap = length / (basis.size if closed else basis.size - 1)
    stiffness = (reach / gap) ** 4 / MEAN_SQUARE
    return basis.design(at) @ basis.solve(rows, values, weights, stiffness)


def _straight_between(
    s: np.ndarray, values: np.ndarray, length: float, closed: bool, at: np.ndarray
) -> np.ndarray:
    """Return values (k, m) at arc lengths `at` (k,), linear between the values (n, m) at s (n,)."""
    period = length if closed else None
    return np.stack([np.interp(at, s, column, period=period) for column in values.T], axis=1)


def _off_ends(s: np.ndarray, length: float, closed: bool, spacing: float) -> np.ndarray:
    """Return a mask (n,) of rows at ascending arc lengths s (n,), at least END spacings from each end.

    If the front is too short for such rows, the mask holds its rows farthest from the ends.
    """
    wide = np.append(s[1:], s[0] + length) - s > GAP * spacing
    wide[-1] |= not closed
    ends = np.concatenate([s[wide], np.roll(s, -1)[wide]])
    off = ways_along(s, ends, length, closed).min(axis=1, initial=np.inf)
    return off >= min(END * spacing, off.max(initial=0.0))
