"""Cubic B-splines in a front's arc length: periodic or open, fitted by least squares."""

from dataclasses import dataclass
from math import factorial

import numpy as np
import scipy

DEGREE = 3
# Weight of the squared coefficients relative to the data; it makes solutions unique where data are too few.
SMALLEST = 1e-14
# Fewest pieces (spans between breaks) of a closed curve: with fewer its B-splines are not distinct.
LEAST_CLOSED = DEGREE + 1


@dataclass(frozen=True, eq=False)
class CubicBasis:
    """Cubic B-splines over arc length; breaks (m + 1,) ascend from 0 to the length; periodic if closed."""

    breaks: np.ndarray
    closed: bool

    @property
    def length(self) -> float:
        """The curve's length."""
        return float(self.breaks[-1])

    @property
    def size(self) -> int:
        """The number of B-splines."""
        return len(self.breaks) - 1 + (0 if self.closed else DEGREE)

    def design(self, s: np.ndarray) -> "scipy.sparse.csr_array":
        """Return the values (k, size) of all B-splines at arc lengths s (k,).

        Beyond the ends of an open curve these are the values at the nearer end.
        """
        s = np.mod(s, self.length) if self.closed else np.clip(s, 0.0, self.length)
        rows = scipy.sparse.csr_array(scipy.interpolate.BSpline.design_matrix(s, self._knots(), DEGREE))
        folded = scipy.sparse.csr_array(
            (rows.data, rows.indices % self.size, rows.indptr), (len(s), self.size)
        )
        folded.sum_duplicates()
        return folded

    def solve(
        self, rows: "scipy.sparse.sparray", values: np.ndarray, weights: np.ndarray, stiffness: float
    ) -> np.ndarray:
        """Return the coefficients (size, c) with which rows (k, size) best fit values (k, c).

        weights (k,): of the rows; stiffness: weight of the squared changes of slope between coefficients,
        relative to a typical diagonal entry of the normal equations. It smooths the result, and determines
        it where there are no data.
        """
        rows = scipy.sparse.csr_array(rows)
        weighted = rows.T @ scipy.sparse.diags_array(weights)
        normal = weighted @ rows
        diagonal = normal.diagonal()
        scale = np.median(diagonal[diagonal > 0]) if diagonal.any() else 1.0
        bend = self._bends()
        system = normal + scale * (
            stiffness * (bend.T @ bend) + SMALLEST * scipy.sparse.eye_array(self.size)
        )
        return scipy.sparse.linalg.splu(system.tocsc()).solve(np.ascontiguousarray(weighted @ values))

    def pieces(self, coefficients: np.ndarray) -> "scipy.interpolate.PPoly":
        """Return the spline of coefficients (size, c) as polynomials between the breaks."""
        if self.closed:
            coefficients = coefficients[np.arange(self.size + DEGREE) % self.size]
        spline, at = scipy.interpolate.BSpline(self._knots(), coefficients, DEGREE), self.breaks[:-1]
        powers = [spline(at, nu=k) / factorial(k) for k in range(DEGREE, -1, -1)]
        return scipy.interpolate.PPoly(np.stack(powers), self.breaks)

    def _knots(self) -> np.ndarray:
        if not self.closed:
            return np.concatenate([np.zeros(DEGREE), self.breaks, np.full(DEGREE, self.length)])
        steps = np.diff(self.breaks)
        turn = np.arange(len(steps) - DEGREE, len(steps)) % len(steps)
        before = -np.cumsum(steps[turn][::-1])[::-1]
        after = self.length + np.cumsum(steps[np.arange(DEGREE) % len(steps)])
        return np.concatenate([before, self.breaks, after])

    def _bends(self) -> "scipy.sparse.csr_array":
        """Return the operator (b, size) from coefficients to the changes of slope between them.

        A straight line gives 0. Distances between coefficients are relative to their mean.
        """
        n, knots = self.size, self._knots()
        rows = n if self.closed else n - 2
        if n < DEGREE:
            return scipy.sparse.csr_array((0, n))
        triples = [knots[1 + k : len(knots) - DEGREE + k] for k in range(DEGREE)]
        places = np.mean(triples, axis=0)  # Greville's abscissae
        gap = np.diff(np.append(places, places[1:3] + self.length) if self.closed else places)
        gap = gap[: rows + 1] / gap.mean()
        behind, ahead = 1 / gap[:rows], 1 / gap[1 : rows + 1]
        values = np.stack([behind, -behind - ahead, ahead], axis=1)
        at = np.repeat(np.arange(rows), 3)
        columns = (np.arange(rows)[:, None] + np.arange(3)) % n
        return scipy.sparse.csr_array((values.ravel(), (at, columns.ravel())), (rows, n))


def graded_basis(
    s: np.ndarray, sizes: np.ndarray, length: float, closed: bool, spacing: float
) -> CubicBasis:
    """Return a basis whose pieces are about `spacing` local sizes long; their number is whole.

    s (k,), sizes (k,): arc lengths and local edge lengths of the front's nodes; length: of the whole curve,
    the closing segment included.
    """
    at = np.append(s, length) if closed else s
    size = np.append(sizes, sizes[0]) if closed else sizes
    count = np.concatenate([[0.0], np.cumsum(np.diff(at) * 0.5 * (1 / size[1:] + 1 / size[:-1]))])
    pieces = max(round(count[-1] / spacing), LEAST_CLOSED if closed else 1)
    breaks = np.interp(np.linspace(0.0, count[-1], pieces + 1), count, at)
    breaks[-1] = length
    return CubicBasis(breaks, closed)


def even_basis(length: float, closed: bool, spacing: float) -> CubicBasis:
    """Return a basis with pieces of one length, about `spacing`, on a curve of the given `length`."""
    pieces = max(round(length / spacing), LEAST_CLOSED if closed else 1)
    return CubicBasis(np.linspace(0.0, length, pieces + 1), closed)
