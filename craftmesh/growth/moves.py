"""Where each point of a front goes, made smooth along it."""

from dataclasses import dataclass, fields

import numpy as np
from scipy.signal import savgol_filter

from craftmesh.cracks.polyline import Polyline
from craftmesh.growth.options import SmoothingOptions
from craftmesh.mesh.cubic_basis import even_basis

# Spacing of the knots of the fit in front spacings. 4 follow a kink angle along an inclined penny of ten
# spacings' radius within its noise, as they do for the intensities themselves.
KNOTS = 4.0
# Least spacing of those knots over the extension: what turns to and fro along less than a step folds its
# strip. Kink angles of a wavy crack went from -20 to 47 degrees along half a step, and it stood in spikes.
PER_STEP = 1.0
# Weight of the spline's changes of slope against the rows: holds the fit where a front has no rows,
# at its ends and across a void. At an end noise of the rows comes through doubled with it, and twentyfold
# with a thousandth of it, which folded a crack whose kink angles jump by 10 degrees between grains; one
# wave round forty rows of a closed front loses 0.06 %.
STIFFNESS = 1e-2
# With fewer rows off the ends, those at the ends count too.
LEAST_ROWS = 3
# Rows this near to an end of a front, in front spacings, are left out of the fit, which goes on straight
# there. K_II and K_III have no bound where a front meets a free surface, and the integrals reach over it:
# with those rows the ends of a tilted half penny kinked by 35 degrees, to and fro at each increment.
END = 2.0
# Rows farther apart than so many spacings have an end between them, as at a void.
GAP = 3.0


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
    over 1 the moves themselves are made smooth, the fit's knots so many times farther apart.
    """
    goes = along.extension > 0
    trusted = along.trusted & goes if (along.trusted & goes).any() else goes
    least = PER_STEP * float(np.median(along.extension[goes]))

    def fitted(values: np.ndarray, trusted: np.ndarray | None) -> np.ndarray:
        return smoothed(s, values, line.length, line.closed, line.arc, options, trusted, least, coarser)

    lengths = fitted(along.extension[:, None], trusted)
    if coarser > 1:
        moves = fitted(along.moves, trusted)
        return _as_long(moves, lengths)
    ahead, aside = fitted(along.parts, trusted).T
    tangent = line.tangents()
    normal, binormal = (fitted(directions, None) for directions in (along.normal, along.binormal))
    binormal -= (binormal * tangent).sum(axis=1, keepdims=True) * tangent
    return _as_long(ahead[:, None] * _unit(binormal) + aside[:, None] * _unit(normal), lengths)


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
    least: float = 0.0,
    coarser: float = 1.0,
) -> np.ndarray:
    """Return values (k, m) at arc lengths (k,) of a front, from those (n, m) of its rows at s (n,).

    `length` is the front's; trusted (n,) bool: the rows that count, all where there are none. fit: least
    squares on cubic B-splines with knots KNOTS row spacings apart, or `least` where that is more, `coarser`
    times that, END off a front's ends; savitzky_golay: a parabola in a window of rows (the paper, section
    2); none: straight between the rows.
    """
    counts = np.ones(len(s), bool) if trusted is None or not trusted.any() else trusted
    if options.smoothing == "fit":
        spacing = np.median(np.diff(s)) if len(s) > 1 else length
        inside = counts & _off_ends(s, length, closed, spacing)
        if inside.sum() <= LEAST_ROWS:
            inside = counts
        s, values = s[inside], values[inside]
        basis = even_basis(length, closed, coarser * max(KNOTS * spacing, least))
        return basis.design(at) @ basis.solve(basis.design(s), values, np.ones(len(s)), STIFFNESS)
    values = interpolated(s[counts], values[counts], length, closed, s)
    if options.smoothing == "savitzky_golay" and len(s) >= options.window:
        width = options.window // 2 * 2 + 1
        values = savgol_filter(values, width, 2, axis=0, mode="wrap" if closed else "interp")
    return interpolated(s, values, length, closed, at)


def interpolated(
    s: np.ndarray, values: np.ndarray, length: float, closed: bool, at: np.ndarray
) -> np.ndarray:
    """Return values (k, m) at arc lengths (k,), straight between those (n, m) at s (n,)."""
    if closed:
        s, values = np.concatenate([s - length, s, s + length]), np.concatenate([values] * 3)
    return np.stack([np.interp(at, s, column) for column in values.T], axis=1)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _off_ends(s: np.ndarray, length: float, closed: bool, spacing: float) -> np.ndarray:
    """Tell which rows at ascending arc lengths s (n,) are no nearer than END spacings to an end."""
    ahead = np.append(s[1:], s[0] + length) - s
    wide = ahead > GAP * spacing
    if not closed:
        wide[-1] = True
    tails, heads = s[wide], np.roll(s, -1)[wide]
    ends = np.concatenate([tails, heads, tails - length, heads - length, tails + length, heads + length])
    off = np.abs(s[:, None] - ends).min(axis=1, initial=np.inf)
    return off >= END * spacing
