"""Files of a residual stress: a table of points, or the point or cell data of a .vtu."""

import os
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml
from craftmesh.io.stage_npz import VTK_ORDER
from craftmesh.io.text_table import read_table

NAMES = ("sxx", "syy", "szz", "sxy", "sxz", "syz")
ARRAYS = ("residual_stress", "stress")
_SYMMETRIC = [0, 4, 8, 1, 2, 5]  # columns of NAMES among the nine components of a tensor


def read_stress_field(path: str | os.PathLike) -> tuple[np.ndarray, tuple[int, ...], np.ndarray]:
    """Return points (k, d), the d axes of their coordinates, and stresses (k, 6) in the order of NAMES.

    A table lacks the coordinates along which the stress is uniform, and stresses that are 0. A .vtu has one
    of ARRAYS: six components in VTK's order, or nine. Raises CraftmeshError for other files, and for
    tensors that are not symmetric.
    """
    if Path(path).suffix == ".vtu":
        return _of_grid(path)
    table = read_table(path, *((name,) for name in NAMES))
    axes = tuple(axis for axis, name in enumerate("xyz") if table.has([name]))
    known = [column for column, name in enumerate(NAMES) if table.has([name])]
    if not known or (not axes and len(table.rows) > 1):
        raise CraftmeshError(
            f"{path}: its columns are {', '.join(table.names) or 'not named'}; expected x, y, z, those "
            f"along which the stress varies, and {', '.join(NAMES)}, those that are not 0"
        )
    stress = np.zeros((len(table.rows), len(NAMES)))
    stress[:, known] = table.numbers([NAMES[column] for column in known])
    points = table.numbers(["xyz"[axis] for axis in axes]) if axes else np.zeros((1, 0))
    return points, axes, stress


def _of_grid(path: str | os.PathLike) -> tuple[np.ndarray, tuple[int, ...], np.ndarray]:
    grid = vtk_xml.read_dataset(path, "UnstructuredGrid")
    at_points = not grid.at_points.keys().isdisjoint(ARRAYS)
    data, points = (grid.at_points, grid.points) if at_points else (grid.at_cells, grid.centres("Cells"))
    stress = vtk_xml.named_array(path, data, ARRAYS, "point or cell data").astype(float)
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
