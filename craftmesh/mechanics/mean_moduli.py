"""Mean moduli of stiffnesses, as of a body of crystals of all orientations."""

from typing import NamedTuple

import numpy as np

# Engineering shears are twice those of tensors.
_OF_TENSOR = np.multiply.outer([1, 1, 1, 0.5, 0.5, 0.5], [1, 1, 1, 0.5, 0.5, 0.5])


class MeanModuli(NamedTuple):
    """Bulk and shear moduli (g,): voigt's of the same strain everywhere, reuss's of the same stress."""

    voigt_bulk: np.ndarray
    voigt_shear: np.ndarray
    reuss_bulk: np.ndarray
    reuss_shear: np.ndarray


def mean_moduli(stiffness: np.ndarray) -> MeanModuli:
    """Return the mean moduli of stiffnesses (g, 6, 6), whose last three components are shears."""
    compliance = _means(np.linalg.inv(stiffness) * _OF_TENSOR)
    return MeanModuli(*_means(stiffness), 1 / (9 * compliance[0]), 1 / (4 * compliance[1]))


def _means(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean bulk and shear terms (g,) of (g, 6, 6) over the components of tensors."""
    stretch = np.trace(matrix[:, :3, :3], axis1=1, axis2=2)
    across = matrix[:, :3, :3].sum(axis=(1, 2)) - stretch
    shear = np.trace(matrix[:, 3:, 3:], axis1=1, axis2=2)
    return (stretch + across) / 9, (2 * stretch - across + 6 * shear) / 30
