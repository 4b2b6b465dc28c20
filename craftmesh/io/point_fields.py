"""Files of a residual stress or a temperature: a table of points, or the point or cell data of a .vtu."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml
from craftmesh.io.stage_npz import VTK_ORDER
from craftmesh.io.text_table import read_table

NAMES = ("sxx", "syy", "szz", "sxy", "sxz", "syz")
ARRAYS = ("residual_stress", "stress")
TEMPERATURE = ("temperature",)  # name of the column, and of the array
_SYMMETRIC = [0, 4, 8, 1, 2, 5]  # columns of NAMES among the nine components of a tensor


def read_stress_field(path: str | os.PathLike) -> tuple[np.ndarray, tuple[int, ...], np.ndarray]:
    """Return points (k, d), the d axes of their coordinates, and stresses (k, 6) in the order of NAMES.

    A table lacks the coordinates along which the stress is uniform, and stresses that are 0. A .vtu has one
    of ARRAYS: six components in VTK's order, or nine. Raises CraftmeshError for other files, and for
    tensors that are not symmetric.
    """
    if Path(path).suffix != ".vtu":
        return _of_table(path, NAMES, "the stress varies")
    points, stress = _of_grid(path, ARRAYS)
    if stress.shape[1:] == (len(_SYMMETRIC) + 3,):
        full = stress.reshape(-1, 3, 3)
        off = np.abs(full - full.swapaxes(1, 2)).max(axis=(1, 2), initial=0.0)
        if off.max(initial=0.0) > np.finfo(np.float32).eps ** 0.5 * np.abs(full).max():
            raise CraftmeshError(
                f"{path}: the tensor {np.argmax(off)} is not symmetric by {off.max():g}; give stresses"
            )
        stress = stress[:, _SYMMETRIC]
    elif stress.shape[1:] == (len(NAMES),):
        stress = stress[:, VTK_ORDER]
    if stress.shape[1:] != (len(NAMES),) or not len(stress) or not np.isfinite(stress).all():
        raise CraftmeshError(
            f"{path}: has an array {stress.shape} of stresses, or one that is not finite; expected finite "
            "rows of six components xx, yy, zz, xy, yz, xz, or of all nine"
        )
    return points, (0, 1, 2), stress


def read_temperature(path: str | os.PathLike) -> tuple[np.ndarray, tuple[int, ...], np.ndarray]:
    """Return points (k, d), the d axes of their coordinates, and temperatures (k, 1) there.

    A table lacks the coordinates along which the temperature is uniform. Raises CraftmeshError for other
    files.
    """
    if Path(path).suffix != ".vtu":
        return _of_table(path, TEMPERATURE, "the temperature varies")
    points, found = _of_grid(path, TEMPERATURE)
    if found.size != len(found) or not len(found) or not np.isfinite(found).all():
        raise CraftmeshError(
            f"{path}: has an array {found.shape} of temperatures, or one that is not finite; expected one "
            "finite number for each point or cell"
        )
    return points, (0, 1, 2), found.reshape(-1, 1)


def _of_table(
    path: str | os.PathLike, names: Sequence[str], varies: str
) -> tuple[np.ndarray, tuple[int, ...], np.ndarray]:
    """Return points, axes and values (k, c) of a table's columns `names` (c,), 0 for missing columns."""
    table = read_table(path, *((name,) for name in names))
    axes = tuple(axis for axis, name in enumerate("xyz") if table.has([name]))
    known = [column for column, name in enumerate(names) if table.has([name])]
    if not known or (not axes and len(table.rows) > 1):
        columns = ", ".join(names) + ", those that are not 0" * (len(names) > 1)
        raise CraftmeshError(
            f"{path}: its columns are {', '.join(table.names) or 'not named'}; expected x, y, z, those "
            f"along which {varies}, and {columns}"
        )
    values = np.zeros((len(table.rows), len(names)))
    values[:, known] = table.numbers([names[column] for column in known])
    points = table.numbers(["xyz"[axis] for axis in axes]) if axes else np.zeros((1, 0))
    return points, axes, values


def _of_grid(path: str | os.PathLike, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of a .vtu, or the centres of its cells, and their array: the first of `names`."""
    grid = vtk_xml.read_dataset(path, "UnstructuredGrid")
    at_points = not grid.at_points.keys().isdisjoint(names)
    data, points = (grid.at_points, grid.points) if at_points else (grid.at_cells, grid.centres("Cells"))
    return points, vtk_xml.named_array(path, data, names, "point or cell data").astype(float)
