"""Strains along a front from its own displacements, and the T-stress that belongs to them."""

from dataclasses import dataclass

import numpy as np

from craftmesh.fracture.fit import SMOOTH, STRAIGHT, FrontLine, segment_basis
from craftmesh.fracture.segments import Segments
from craftmesh.fracture.tube import Surroundings
from craftmesh.mesh.cubic_basis import CubicBasis
from craftmesh.mesh.front_curve import FrontCurve
from craftmesh.mesh.front_frames import Front

# Pieces of the splines through the front's displacements, in local sizes; segments with fewer nodes, mid
# nodes among them, get a straight line.
PIECES, LEAST_NODES = 3.0, 7
# Strains 11, 33 and 13 among 11, 22, 33, 12, 13, 23 in the axes binormal, normal, tangent: the others
# follow from lips that are free of traction.
_IN_LIPS = np.array([0, 2, 4])


@dataclass(frozen=True, eq=False)
class FrontStrain:
    """Displacements along one segment of a front, as a spline over offsets from its start."""

    basis: CubicBasis
    coefficients: np.ndarray
    curve: FrontCurve
    start: float

    def at(self, offset: np.ndarray) -> np.ndarray:
        """Return the displacement's slopes (k, 2) along the front: its parts along tangent and binormal."""
        slope = self.basis.slopes(offset, self.coefficients)
        _, tangent, _, binormal = self.curve.frames(self.start + offset)
        return np.stack([(slope * axis).sum(axis=1) for axis in (tangent, binormal)], axis=1)


def strains_along_front(
    around: Surroundings, front: Front, line: FrontLine, segments: Segments
) -> list[FrontStrain]:
    """Return the strain of each segment less its eigenstrain, from its nodes' displacements.

    They are those of the tube, whose mean turn is taken out: fields of unit forces tell the strain without.
    """
    begin, end = line.edges()
    s = np.concatenate([line.s, 0.5 * (begin + end)])
    nodes = np.searchsorted(around.nodes, np.concatenate([front.corners, front.mids]))
    points, displacement = around.tube.points[nodes], around.tube.displacement[nodes]
    found = []
    for segment, (start, length) in enumerate(zip(segments.start, segments.length)):
        offset = np.mod(s - start, line.total) if segments.closed else s - start
        own = (offset >= 0) & (offset <= length * (1 + 1e-9))
        basis = segment_basis(line, segments, segment, PIECES)
        stiffness = SMOOTH if own.sum() >= LEAST_NODES else STRAIGHT
        rows, weights = basis.design(offset[own]), np.ones(own.sum())
        moved = displacement - points @ segments.eigenstrain[segment]
        coefficients = basis.solve(rows, moved[own], weights, stiffness)
        found.append(FrontStrain(basis, coefficients, front.curve, float(start)))
    return found


def stress_along_binormal(stiffness: np.ndarray, ahead: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return T (k,): the stress 11 of the part of the field that stays finite at the front.

    stiffness (k, 6, 6) in the local axes; ahead (k, 2): derivatives by the binormal of the displacements
    along binormal and tangent; along (k, 2): those by the tangent of the displacements along tangent and
    binormal. The lips are free of traction, so stresses 22, 12 and 23 vanish.
    """
    strain = np.column_stack([ahead[:, 0], along[:, 0], ahead[:, 1] + along[:, 1]])
    compliance = np.linalg.inv(stiffness)[:, _IN_LIPS[:, None], _IN_LIPS]
    return np.linalg.solve(compliance, strain[:, :, None])[:, 0, 0]
