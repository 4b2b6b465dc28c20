"""Orientations by grain from what files hold: quaternions, Rodrigues vectors or Bunge's angles."""

import os
from collections.abc import Callable, Mapping

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import EULERS, QUATERNIONS, RODRIGUES, as_numbers, table_rows
from craftmesh.mechanics.orientation import (
    angle_between,
    bunge_to_quaternion,
    mean_by_grain,
    normalized,
    rodrigues_to_quaternion,
)

_KINDS: dict[str, tuple[int, Callable[[np.ndarray], np.ndarray]]] = {
    QUATERNIONS: (4, normalized),
    RODRIGUES: (3, rodrigues_to_quaternion),
    EULERS: (3, bunge_to_quaternion),
}
_MIXED_UP = 1.0  # degrees between two tables of one file; float32 angles agree within 0.1
_MIXED_ANGLES = 15.0  # degrees of spread within a grain above which an average says little


def orientation_table(
    path: str | os.PathLike, given: Mapping[str, np.ndarray], labels: np.ndarray
) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """Return quaternions (g, 4), row = label, NaN unknown, and notes; None where the file has none.

    given: FileVolume.orientations; arrays (nx, ny, nz, k) become the means over the voxels of each of the
    labels (nx, ny, nz). Raises CraftmeshError for tables of another width, and for several tables that do
    not agree.
    """
    tables: dict[str, np.ndarray] = {}
    notes: tuple[str, ...] = ()
    for kind, values in given.items():
        width, convert = _KINDS[kind]
        per_voxel = values.ndim == 4
        rows = values.reshape(-1, values.shape[-1]) if per_voxel else values
        tables[kind] = convert(_checked(f"{path}: {kind}", rows, width))
        if per_voxel:
            table_rows(path, labels)
            tables[kind], spread = mean_by_grain(labels.ravel(), tables[kind])
            notes += _spread_notes(spread)
    if not tables:
        return None, notes
    _refuse_disagreement(path, tables)
    return next(iter(tables.values())), notes


def _spread_notes(spread: float) -> tuple[str, ...]:
    notes: tuple[str, ...] = ("orientations are means over each grain's voxels",)
    if spread > _MIXED_ANGLES:
        notes += (f"orientations spread by up to {spread:.0f} degrees within a grain: check the averages",)
    return notes


def _checked(name: str, table: np.ndarray, width: int) -> np.ndarray:
    table = as_numbers(name, table)
    if table.ndim != 2 or table.shape[1] != width:
        raise CraftmeshError(
            f"{name} has shape {table.shape}; expected one row of {width} numbers per grain id"
        )
    return np.where(np.isfinite(table), table, np.nan)


def _refuse_disagreement(path: str | os.PathLike, tables: Mapping[str, np.ndarray]) -> None:
    (first, table), *others = tables.items()
    for name, other in others:
        rows = min(len(table), len(other))
        both = np.isfinite(table[:rows]).all(axis=1) & np.isfinite(other[:rows]).all(axis=1)
        known = np.flatnonzero(both)
        angles = angle_between(table[known], other[known])
        if angles.max(initial=0.0) > _MIXED_UP:
            worst = int(angles.argmax())
            raise CraftmeshError(
                f"{path}: {first} and {name} differ by {angles[worst]:.1f} degrees for grain "
                f"{known[worst]}; expected one rotation from crystal to sample axes: leave one of them out"
            )
