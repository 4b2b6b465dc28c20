"""What counts as a poor element: what Abaqus' analysis checks warn of (paper, section 4); and as flat."""

import numpy as np

LEAST_SHAPE_FACTOR = 0.02
# Dihedral angles in degrees.
LEAST_DIHEDRAL = 10.0
LARGEST_DIHEDRAL = 160.0
# A flat element is so poor that its stresses mean nothing: it is named with its place.
FLAT_SHAPE_FACTOR = 0.005
FLAT_DIHEDRALS = (5.0, 172.0)


def poor_parts(measures: np.ndarray) -> dict[str, np.ndarray]:
    """Return (m,) bool for each reason to call an element poor, from `shape_measures` (m, 5)."""
    low, high, factor = measures[:, 2], measures[:, 3], measures[:, 4]
    return {
        "shape_factor": factor < LEAST_SHAPE_FACTOR,
        "dihedral_under_10": low < LEAST_DIHEDRAL,
        "dihedral_over_160": high > LARGEST_DIHEDRAL,
    }


def is_poor(measures: np.ndarray) -> np.ndarray:
    """Return (m,) bool: elements that are poor for any reason, from `shape_measures` (m, 5)."""
    return np.logical_or.reduce(list(poor_parts(measures).values()))


def is_flat(measures: np.ndarray) -> np.ndarray:
    """Return (m,) bool: elements that are flat, from `shape_measures` (m, 5)."""
    low, high, factor = measures[:, 2], measures[:, 3], measures[:, 4]
    return (factor < FLAT_SHAPE_FACTOR) | (low < FLAT_DIHEDRALS[0]) | (high > FLAT_DIHEDRALS[1])
