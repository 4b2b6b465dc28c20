"""Where each point of a front goes, made smooth along it, and which stay where they are."""

import numpy as np
import scipy
from scipy.sparse import vstack

from craftmesh.cracks.polyline import Polyline
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.options import SmoothingOptions
from craftmesh.growth.trust import END, or_all
from craftmesh.mesh.cubic_basis import even_basis
from craftmesh.mesh.front_curve import square_to, unit, ways_along

# Spacing of the knots of the fit in front spacings. 4 follow a kink angle along an inclined penny of ten
# spacings' radius within its noise, as they do for the intensities themselves.
KNOTS = 4.0
# The fit halves waves along the front of wave number 1 / reach. That is a front spacing at least: at an end
# noise of the rows comes through doubled, and twentyfold with a sixth of it, which folded a crack whose
# kink angles jump by 10 degrees between grains. And it is so much of the extension. A front that is off its
# plane by a wave of number k turns back by k times that in a unit of extension (Movchan, Gao & Willis 1998;
# Poisson's ratio 0), so that a step of over 1 / k takes it past the plane. 3^(3/4) / 4 is the least share
# with which the fit lets no wave do so.
OF_STEP = 0.57
# Mean square of a cubic B-spline over a spacing of its knots.
MEAN_SQUARE = 151 / 315
# Rows farther apart than so many spacings have an end between them, as at a void.
GAP = 3.0


def points_at_rest(line: Polyline, s: np.ndarray, goes: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of a front's points that stay; its rows at arc lengths s (n,) go on where `goes`.

    A point does as the row next to it, and the point next to a row that stays does so too.
    """
    way = ways_along(line.arc, s, line.length, line.closed)
    rest = ~goes[way.argmin(axis=1)]
    rest[way[:, ~goes].argmin(axis=0)] = True
    if line.closed:
        rest[[0, -1]] = rest[0] | rest[-1]
    return rest


def beside_rest(line: Polyline, rest: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return moves (k, 3) no longer than the way along the front to the next point at rest (k,) bool.

    So the new front leaves the old one at 45 degrees at most: K has no jump along a front, nor has its
    extension, and elements beside a sharper corner would be flat.
    """
    room = ways_along(line.arc, line.arc[rest], line.length, line.closed).min(axis=1, initial=np.inf)
    size = np.linalg.norm(moves, axis=1)
    return np.minimum(1.0, room / np.maximum(size, np.finfo(float).tiny))[:, None] * moves


def moves_along(
    line: Polyline, s: np.ndarray, step: FrontStep, options: SmoothingOptions, coarser: float
) -> np.ndarray:
    """Return the moves (k, 3) of the points of a front `line` from its rows `step` at ascending s (n,).

    Rows that are not trusted or stay take kink and extension straight between those that are trusted and go
    on. Both are `smoothed`, over `coarser` times the length, as are the directions of all rows, along which
    they are laid: at an end the crack's normal may be that of one facet, turned by 40 degrees.
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
    """Return values (k, m) at arc lengths (k,) of a front, from those (n, m) of its rows at s (n,).

    `length` is the front's. fit: see `_fitted`, smooth over a row spacing or OF_STEP of the extension
    `step`; savitzky_golay: a parabola in a window of rows (the paper, section 2); none: straight between
    the rows.
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
    """Return values (k, m) at arc lengths (k,) of the cubic spline nearest to those (n, m) at s (n,).

    Least squares, and reach^4 times the second derivative's square: 1 / (1 + (k reach)^4) of a wave of
    number k is left, and an open front goes on straight at its ends. Its trend from end to end costs
    reach^3 times its square: a plate of few edges, whose rows off the ends tell of none, does not twist on
    their noise.
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
    """Return values (k, m) at arc lengths (k,), straight between those (n, m) at s (n,)."""
    period = length if closed else None
    return np.stack([np.interp(at, s, column, period=period) for column in values.T], axis=1)


def _off_ends(s: np.ndarray, length: float, closed: bool, spacing: float) -> np.ndarray:
    """Return a mask of rows at ascending arc lengths s (n,), no nearer than END spacings to an end.

    The fit goes on straight there. Of a front too short for any, those in its middle.
    """
    wide = np.append(s[1:], s[0] + length) - s > GAP * spacing
    wide[-1] |= not closed
    ends = np.concatenate([s[wide], np.roll(s, -1)[wide]])
    off = ways_along(s, ends, length, closed).min(axis=1, initial=np.inf)
    return off >= min(END * spacing, off.max(initial=0.0))
