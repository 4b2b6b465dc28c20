"""From contributions of nodes to values along the front: hats as test functions, then fits of B-splines.

A hat is a function of the arc length that is 1 at a node of the front and falls linearly to 0 on both
sides.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from craftmesh.fracture.segments import Segments, is_isotropic
from craftmesh.fracture.tube import Tube
from craftmesh.mesh.cubic_basis import CubicBasis, graded_basis
from craftmesh.mesh.front_curve import sizes_at_bends, ways_along
from craftmesh.mesh.front_frames import Front

# Half width of a hat in local sizes (mean edge lengths nearby): hats of one edge see each irregularity of
# the mesh (errors of 3 % instead of 0.7 %), wider ones are smoother than the splines need.
HALF_WIDTH = 2.0
# Fraction of the tube's radius up to which q, the virtual extension, is constant; from there it falls to 0.
# At the smallest radius, 2.5 edges, it then falls only beyond the elements that touch the front. With 0.4,
# K in a tube of this radius erred by 0.9 % on a lens crack (now 0.34, as with a radius of four edges), and
# in a polycrystal differed by 1.7 % from K in a wide tube (now 0.13). Without a plateau, K_I errs by 0.7 %.
PLATEAU = 0.6
# Fewest hats on a segment, or nodes with known displacements, for a spline of stiffness SMOOTH. With fewer
# the stiffness is STRAIGHT, which makes the spline a straight line.
LEAST_KNOWN = 6
STRAIGHT, SMOOTH = 1e6, 1e-6
# Longest spline piece over the front's bend radius: K varies as fast as the front bends. On the ellipse
# 25:6 splines of four edges through its exact K miss it by 0.7 % at the sharp ends.
OF_BEND = 0.8
# Factor on the length of spline pieces in crystals. The lips' opening, which is fitted, does not vary as
# the crystal's axes turn along the front; errors of elements do, in waves of ten edges. With ten edges to
# the crack's radius and pieces of four edges, K errs by 2.0 % in a crystal with a Zener ratio of 8 and by
# 0.6 % in copper; with pieces of six edges by 0.5 and 0.25 %.
IN_CRYSTALS = 1.5
# Gauss points on each edge of the front: exact for a quadratic times a cubic.
_GAUSS, _WEIGHT = (a / 2 for a in np.polynomial.legendre.leggauss(4))
# Length of the pieces of splines through the front's displacements, in local sizes.
PIECES = 3.0
# Rows of the strains 11, 33 and 13 among 11, 22, 33, 12, 13, 23 in the axes binormal, normal, tangent. The
# other three strains follow from these, because lips are free of traction.
_IN_LIPS = np.array([0, 2, 4])
# Places of 11, 22, 33, 12, 13, 23 among the nine components of a tensor, row by row.
_OF_NINE = np.array([0, 4, 8, 1, 2, 5])


@dataclass(frozen=True, eq=False)
class FrontLine:
    """A front's corner nodes along its arc length.

    s (k,): their arc lengths; sizes (k,): local sizes, mean edge lengths nearby; bend (k,): the front's
    bend radius at the nodes; total: the front's length.
    """

    s: np.ndarray
    sizes: np.ndarray
    bend: np.ndarray
    total: float
    closed: bool

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the arc lengths (e,) at which the front's edges begin, and the ones at which they end."""
        if self.closed:
            return self.s, np.append(self.s[1:], self.total)
        return self.s[:-1], self.s[1:]

    def along(self, values: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Return the nodes' `values` (k,), interpolated linearly at arc lengths s (m,)."""
        return np.interp(s, self.s, values, period=self.total if self.closed else None)

    def near(self, places: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return a mask (k,) of nodes with one of the arc lengths `places` (m,) within radius (k,)."""
        way = ways_along(self.s, places, self.total, self.closed)
        return way.min(axis=1, initial=np.inf) < radius


@dataclass(frozen=True, eq=False)
class Tests:
    """Hat functions along a front segment: centres (k,), offsets from its start, and half widths (k,).

    Offsets are arc lengths. A hat is 1 at its centre and falls linearly to 0. before, behind: half widths
    towards smaller and larger offsets; inf keeps the hat at 1 on this side.
    """

    centres: np.ndarray
    before: np.ndarray
    behind: np.ndarray
    period: float  # length of a closed front that is one segment, else 0

    def values(self, offset: np.ndarray) -> csr_array:
        """Return the values (k, n) of the k hat functions at offsets (n,), in arc length."""
        order = np.argsort(offset, kind="stable")
        ordered = offset[order]
        turns = (-self.period, 0.0, self.period) if self.period else (0.0,)
        rows, columns, values = [], [], []
        for k, (centre, before, behind) in enumerate(zip(self.centres, self.before, self.behind)):
            for turn in turns:
                low = np.searchsorted(ordered, centre + turn - before)
                high = np.searchsorted(ordered, centre + turn + behind, side="right")
                d = ordered[low:high] - centre - turn
                rows.append(np.full(high - low, k))
                columns.append(order[low:high])
                with np.errstate(invalid="ignore"):
                    hat = 1 - np.abs(d) / np.where(d < 0, before, behind)
                values.append(np.where(np.isfinite(hat), np.clip(hat, 0, 1), 1.0))
        place = (np.concatenate(rows), np.concatenate(columns))
        return csr_array((np.concatenate(values), place), (len(self.centres), len(offset)))


@dataclass(frozen=True, eq=False)
class Fitted:
    """Values along one segment: splines over offsets from its start, or constants if basis is None.

    coefficients (b, c): of the b basis splines for c values; with constants (1, c).
    """

    basis: CubicBasis | None
    coefficients: np.ndarray

    def at(self, offset: np.ndarray) -> np.ndarray:
        """Return the c values (k, c) at offsets (k,), arc lengths from the segment's start."""
        if self.basis is None:
            return np.repeat(self.coefficients, len(offset), axis=0)
        return self.basis.design(offset) @ self.coefficients

    def slopes(self, offset: np.ndarray) -> np.ndarray:
        """Return the derivatives (k, c) of the c values by arc length at offsets (k,)."""
        if self.basis is None:
            return np.zeros((len(offset), self.coefficients.shape[1]))
        return self.basis.pieces(self.coefficients)(offset, 1)


def falloff(distance: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return the factor (n,) by which q, the virtual extension, falls away from the front, from 1 to 0.

    The factor is 1 up to a distance (n,) of PLATEAU times the tube's radius (n,), then falls linearly to 0
    there.
    """
    return np.clip((1 - distance / radius) / (1 - PLATEAU), 0, 1)


def tests_on(line: FrontLine, segments: Segments, segment: int) -> Tests:
    """Return a hat function at each corner node inside a segment; hats end where the material changes.

    At the ends of an open front there are hats too, which keep 1 beyond the end. A segment without a corner
    inside gets one hat over its length.
    """
    length, ring = segments.length[segment], segments.is_ring
    rows, offset = segments.within(segment, line.s)
    whole_start = not segments.closed and segment == 0
    whole_end = not segments.closed and segment == len(segments.start) - 1
    inside = (offset > 0) & (offset < length)
    inside |= (offset == 0) & (ring or whole_start) | (offset == length) & whole_end
    centres, width = offset[inside], HALF_WIDTH * line.sizes[rows[inside]]
    if not len(centres):
        centres, width = np.array([length / 2]), np.array([length])
    if ring:
        width = np.minimum(width, length / 2)
        return Tests(centres, width, width, length)
    before = np.minimum(width, np.inf if whole_start else centres)
    behind = np.minimum(width, np.inf if whole_end else length - centres)
    before = np.where(centres == 0, np.inf, before)
    behind = np.where(centres == length, np.inf, behind)
    return Tests(centres, before, behind, 0.0)


def fit_segment(
    line: FrontLine,
    segments: Segments,
    segment: int,
    s: np.ndarray,
    weights: np.ndarray,
    knots: float,
    has_j: np.ndarray,
) -> Fitted:
    """Return c values along a segment, whose integrals with the hat functions fit the given ones.

    The given integrals are sums of the nodes' contributions, weighted by the hat functions. The fit is by
    least squares. s (n,): arc lengths of the segment's nodes; weights (n, c): their contributions to the
    integrals times `falloff`; knots: length of the spline pieces in local sizes. has_j (k,): mask of the
    front's nodes to whose hat functions J, the last value, is fitted; to all of the segment if it has none.
    """
    tests = tests_on(line, segments, segment)
    integrals = tests.values(segments.offset(segment, s)) @ weights
    at, share = _gauss_on_edges(line, segments, segment, tests)
    measure = share.sum(axis=1)
    if len(tests.centres) < 2:
        return Fitted(None, integrals / measure[:, None])
    basis = segment_basis(line, segments, segment, knots)
    stiffness = SMOOTH if segments.is_ring or len(tests.centres) >= LEAST_KNOWN else STRAIGHT
    rows = share @ basis.design(at)
    coefficients = basis.solve(rows, integrals, 1 / measure, stiffness)
    kept = line.along(has_j.astype(float), segments.start[segment] + tests.centres) > 0.5
    if kept.any() and not kept.all():
        coefficients[:, -1:] = basis.solve(rows, integrals[:, -1:], kept / measure, stiffness)
    return Fitted(basis, coefficients)


def segment_basis(line: FrontLine, segments: Segments, segment: int, knots: float) -> CubicBasis:
    """Return the B-splines of a segment over offsets, arc lengths from its start.

    knots: length of the pieces in local sizes; pieces are longer in crystals and shorter at sharp bends.
    """
    knots *= 1.0 if is_isotropic(segments.stiffness[segment]) else IN_CRYSTALS
    sizes = sizes_at_bends(line.sizes, line.bend, OF_BEND / knots)
    if segments.is_ring:
        return graded_basis(line.s, sizes, line.total, True, knots)
    length = segments.length[segment]
    kept, offset = segments.within(segment, line.s)
    at = np.concatenate([[0.0], offset, [length]])
    sizes = sizes[kept] if len(kept) else np.array([length])
    sizes = np.concatenate([sizes[:1], sizes, sizes[-1:]])
    return graded_basis(at, sizes, length, False, knots)


def _gauss_on_edges(
    line: FrontLine, segments: Segments, segment: int, tests: Tests
) -> tuple[np.ndarray, csr_array]:
    """Return offsets (g,) of Gauss points on the segment's edges, and values (k, g) of the hats there.

    The values are multiplied by the weights of the Gauss points. On each edge a hat is replaced by the
    quadratic through its values at both ends and the middle, as the shape functions do with q in the mesh.
    """
    begin, end = (edge[segments.of_edge == segment] for edge in line.edges())
    length = end - begin
    begin = segments.offset(segment, begin)
    if not segments.is_ring:
        begin = np.where(begin < -1e-9 * segments.total, begin + segments.total, begin)
    x = _GAUSS + 0.5
    known, at = ((begin[:, None] + np.outer(length, part)).ravel() for part in ([0, 0.5, 1], x))
    shapes = np.stack([(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)]) * _WEIGHT
    columns = np.tile(np.arange(len(at)).reshape(-1, 1, len(x)), (1, 3, 1))
    rows = np.arange(0, columns.size + 1, len(x))
    spread = csr_array(((length[:, None, None] * shapes).ravel(), columns.ravel(), rows))
    return at, csr_array(tests.values(known) @ spread)


def displacements_along_front(
    tube: Tube, front: Front, line: FrontLine, segments: Segments
) -> list[Fitted]:
    """Return splines of displacement and temperature (4 columns) along each segment, fitted to front nodes.

    Subtracted are the front's mean temperature, and the displacement that it causes with the segment's
    eigenstrain. The displacement is without the mean rotation of the tube, because the fields of unit
    forces give the strain without this rotation.
    """
    begin, end = line.edges()
    s = np.concatenate([line.s, 0.5 * (begin + end)])
    nodes = np.searchsorted(tube.nodes, np.concatenate([front.corners, front.mids]))
    points, displacement, heat = tube.points[nodes], tube.displacement[nodes], tube.temperature[nodes]
    mean = heat.mean()
    found = []
    for segment in range(len(segments.start)):
        own, offset = segments.within(segment, s)
        basis = segment_basis(line, segments, segment, PIECES)
        stiffness = SMOOTH if len(own) >= LEAST_KNOWN else STRAIGHT
        moved = displacement - mean * points @ segments.eigenstrain[segment]
        moved = np.column_stack([moved, heat - mean])
        rows, weights = basis.design(offset), np.ones(len(own))
        found.append(Fitted(basis, basis.solve(rows, moved[own], weights, stiffness)))
    return found


def stress_along_binormal(stiffness: np.ndarray, ahead: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return T (k,): the stress along the binormal in the part of the field that stays finite at the front.

    stiffness (k, 9, 9): in local axes; ahead (k, 2): derivatives along the binormal of the displacements
    along binormal and tangent; along (k, 2): derivatives along the tangent of the displacements along
    tangent and binormal. Lips are taken as free of traction, so that stresses 22, 12 and 23 vanish.
    """
    strain = np.column_stack([ahead[:, 0], along[:, 0], ahead[:, 1] + along[:, 1]])
    compliance = np.linalg.inv(stiffness[:, _OF_NINE[:, None], _OF_NINE])[:, _IN_LIPS[:, None], _IN_LIPS]
    return np.linalg.solve(compliance, strain[:, :, None])[:, 0, 0]
