"""Where each point of a front goes, made smooth along it, and which stay where they are."""

from dataclasses import dataclass, fields

import numpy as np
from scipy.sparse import vstack
from scipy.spatial import cKDTree

from craftmesh.cracks.polyline import Polyline
from craftmesh.growth.options import SmoothingOptions
from craftmesh.growth.trust import END, or_all
from craftmesh.mesh.cubic_basis import even_basis
from craftmesh.mesh.front_curve import square_to, unit

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
    """Tell which points (k,) of a front stay, whose rows at arc lengths s (n,) go on where `goes` (n,).

    A point does as the row next to it, and the point next to a row that stays does so too.
    """
    rows, arc = _places(line, s), _places(line, line.arc)
    rest = ~goes[_tree(line, rows).query(arc)[1]]
    rest[_tree(line, arc).query(rows[~goes])[1]] = True
    if line.closed:
        rest[[0, -1]] = rest[0] | rest[-1]
    return rest


def beside_rest(line: Polyline, rest: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return moves (k, 3) no longer than the way along the front to the next point at rest (k,) bool.

    So the new front leaves the old one at 45 degrees at most: K has no jump along a front, nor has its
    extension, and elements beside a sharper corner would be flat.
    """
    if not rest.any():
        return moves
    arc = _places(line, line.arc)
    room, _ = _tree(line, arc[rest]).query(arc)
    size = np.linalg.norm(moves, axis=1)
    share = np.minimum(1.0, room / np.maximum(size, np.finfo(float).tiny))
    return np.where(rest[:, None], 0.0, share[:, None] * moves)


def _places(line: Polyline, s: np.ndarray) -> np.ndarray:
    return np.mod(s, line.length)[:, None] if line.closed else s[:, None]


def _tree(line: Polyline, places: np.ndarray) -> cKDTree:
    return cKDTree(places, boxsize=line.length if line.closed else None)


@dataclass(frozen=True)
class FrontExtensions:
    """Where the points of a crack's fronts go: a row for each, in any order.

    points, normal, binormal (n, 3): the crack plane's normal, and the direction out of the crack, square to
    it and to the front. kink_angle (n,) radians from the binormal towards the normal; extension (n,).
    trusted (n,) bool: whether its way says something; others go as the trusted ones beside them. What has
    no extension stays.
    """

    points: np.ndarray
    normal: np.ndarray
    binormal: np.ndarray
    kink_angle: np.ndarray
    extension: np.ndarray
    trusted: np.ndarray

    @property
    def parts(self) -> np.ndarray:
        """(n, 2) how far each row goes along its binormal and its normal."""
        turned = np.column_stack([np.cos(self.kink_angle), np.sin(self.kink_angle)])
        return self.extension[:, None] * turned

    @property
    def moves(self) -> np.ndarray:
        """(n, 3) where each row goes, not made smooth."""
        parts = self.parts
        return parts[:, :1] * self.binormal + parts[:, 1:] * self.normal

    def rows(self, chosen: np.ndarray) -> "FrontExtensions":
        """Return the chosen rows, in their order."""
        return FrontExtensions(*(getattr(self, field.name)[chosen] for field in fields(self)))


def moves_along(
    line: Polyline, s: np.ndarray, along: FrontExtensions, options: SmoothingOptions, coarser: float = 1.0
) -> np.ndarray:
    """Return the moves (k, 3) of the points of a front `line` from its rows `along` at ascending s (n,).

    Of rows that go on, one at least, the parts ahead and aside are made smooth, and laid along the
    directions of all, which are made smooth too: at an end the crack's normal may be that of one facet,
    turned by 40 degrees. Of a front whose own directions turn to and fro that is not enough: with coarser
    over 1 the moves themselves are made smooth, over so many times the length.
    """
    goes = along.extension > 0
    trusted = or_all(along.trusted, goes)
    step = float(np.median(along.extension[goes]))

    def fitted(values: np.ndarray, trusted: np.ndarray | None) -> np.ndarray:
        return smoothed(s, values, line.length, line.closed, line.arc, options, trusted, step, coarser)

    lengths = fitted(along.extension[:, None], trusted)
    if coarser > 1:
        moves = fitted(along.moves, trusted)
        return _as_long(moves, lengths)
    ahead, aside = fitted(along.parts, trusted).T
    tangent = line.tangents()
    normal, binormal = (fitted(directions, None) for directions in (along.normal, along.binormal))
    binormal = square_to(binormal, tangent)
    return _as_long(ahead[:, None] * unit(binormal) + aside[:, None] * unit(normal), lengths)


def _as_long(moves: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return moves (k, 3) with the lengths (k, 1)."""
    size = np.linalg.norm(moves, axis=1, keepdims=True)
    return moves * lengths / np.maximum(size, np.finfo(float).tiny)


def smoothed(
    s: np.ndarray,
    values: np.ndarray,
    length: float,
    closed: bool,
    at: np.ndarray,
    options: SmoothingOptions,
    trusted: np.ndarray | None = None,
    step: float = 0.0,
    coarser: float = 1.0,
) -> np.ndarray:
    """Return values (k, m) at arc lengths (k,) of a front, from those (n, m) of its rows at s (n,).

    `length` is the front's; trusted (n,) bool: the rows that count, all where there are none. fit: see
    `_fitted`, smooth over a row spacing or OF_STEP of the extension `step`, `coarser` times that;
    savitzky_golay: a parabola in a window of rows (the paper, section 2); none: straight between the rows.
    """
    counts = np.ones(len(s), bool)
    counts = counts if trusted is None else or_all(trusted, counts)
    if options.smoothing == "fit":
        spacing = np.median(np.diff(s)) if len(s) > 1 else length
        inside = counts & _off_ends(s, length, closed, spacing)
        rows = inside if inside.any() else counts
        reach = coarser * max(spacing, OF_STEP * step)
        return _fitted(s[rows], values[rows], length, closed, at, KNOTS * spacing, reach)
    values = interpolated(s[counts], values[counts], length, closed, s)
    if options.smoothing == "savitzky_golay" and len(s) >= options.window:
        from scipy.signal import savgol_filter  # half a second, for the paper's filter alone

        width = options.window // 2 * 2 + 1
        values = savgol_filter(values, width, 2, axis=0, mode="wrap" if closed else "interp")
    return interpolated(s, values, length, closed, at)


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


def interpolated(
    s: np.ndarray, values: np.ndarray, length: float, closed: bool, at: np.ndarray
) -> np.ndarray:
    """Return values (k, m) at arc lengths (k,), straight between those (n, m) at s (n,)."""
    period = length if closed else None
    return np.stack([np.interp(at, s, column, period=period) for column in values.T], axis=1)


def _off_ends(s: np.ndarray, length: float, closed: bool, spacing: float) -> np.ndarray:
    """Tell which rows at ascending arc lengths s (n,) are no nearer than END spacings to an end.

    The fit goes on straight there. Of a front too short for any, those in its middle.
    """
    ahead = np.append(s[1:], s[0] + length) - s
    wide = ahead > GAP * spacing
    if not closed:
        wide[-1] = True
    tails, heads = s[wide], np.roll(s, -1)[wide]
    ends = np.concatenate([tails, heads, tails - length, heads - length, tails + length, heads + length])
    off = np.abs(s[:, None] - ends).min(axis=1, initial=np.inf)
    return off >= min(END * spacing, off.max(initial=0.0))
