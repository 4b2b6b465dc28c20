"""Volumes whose header says where their axes point: turned to x, y, z, or refused as oblique."""

import os
from itertools import permutations

import numpy as np

from craftmesh.errors import CraftmeshError, told

_ALIGNED = 1e-4  # of a step: headers have six digits, and over 1000 voxels this is a tenth of one


def along_axes(
    path: str | os.PathLike, labels: np.ndarray, steps: np.ndarray, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return labels (nx, ny, nz) along x, y, z, their spacing (3,) and the lower corner of their box (3,).

    labels: axes in the file's order; steps (3, 3): row k leads from one voxel to the next along axis k;
    first (3,): the centre of the first voxel. Axes that run backwards or stand in another order are turned.
    Raises CraftmeshError for axes that are not those of x, y, z, and for labels of other than three axes.
    """
    if labels.ndim != 3 or steps.shape != (3, 3):
        raise CraftmeshError(
            f"{path}: has {labels.ndim} axes; expected a volume of three, export one label a voxel"
        )
    if not (np.isfinite(steps).all() and np.isfinite(first).all() and steps.any(axis=1).all()):
        raise CraftmeshError(
            f"{path}: its steps are {told(steps)} from {told(first)}; "
            "expected a finite spacing, not 0, and a finite origin"
        )
    order = next((list(p) for p in permutations(range(3)) if _is_diagonal(steps[list(p)])), None)
    if order is None:
        raise CraftmeshError(
            f"{path}: its axes are turned (steps {told(steps)}); resample it on axes x, y, z"
        )
    along = steps[order].diagonal()
    turned = labels.transpose(order)
    lowest = first + np.where(along < 0, (np.array(turned.shape) - 1) * along, 0)
    turned = turned[tuple(slice(None, None, -1 if step < 0 else 1) for step in along)]
    spacing = np.abs(along)
    return turned, spacing, lowest - spacing / 2


def _is_diagonal(steps: np.ndarray) -> bool:
    along = steps.diagonal()
    aside = np.abs(steps - np.diag(along)).max(axis=1)
    return bool((along != 0).all() and (aside <= _ALIGNED * np.abs(along)).all())
