"""Fields of target lengths in .vtp and .vti files."""

from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml

_KINDS = {".vtp": "PolyData", ".vti": "ImageData"}


def read_length_field(path: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Read points (k, 3) and the array `name` of target lengths (k,) there from a .vtp or .vti.

    Cell data count at the cells' centres. Raises CraftmeshError for other files, a missing array, and one
    that is not a scalar.
    """
    kind = _KINDS.get(path.suffix.lower())
    if kind is None:
        raise CraftmeshError(f"{path}: suffix {path.suffix!r}; expected a .vtp or .vti with lengths")
    data = vtk_xml.read_dataset(path, kind)
    at_points = data.GetPointData().GetArray(name) is not None
    attributes = data.GetPointData() if at_points else data.GetCellData()
    lengths = vtk_xml.named_array(path, attributes, [name], "point or cell data")
    if lengths.ndim != 1:
        raise CraftmeshError(f"{path}: {name!r} has {lengths.shape[1]} components; expected one")
    return _points(data) if at_points else _centres(data), lengths


def _points(data: Any) -> np.ndarray:
    if data.IsA("vtkPolyData"):
        return vtk_xml.points_of(data)
    return np.array([data.GetPoint(i) for i in range(data.GetNumberOfPoints())]).reshape(-1, 3)


def _centres(data: Any) -> np.ndarray:
    bounds = np.array([data.GetCell(i).GetBounds() for i in range(data.GetNumberOfCells())])
    if data.IsA("vtkImageData"):
        return bounds.reshape(-1, 3, 2).mean(axis=2)
    connectivity, offsets = vtk_xml.cells_of(data.GetPolys())
    points = vtk_xml.points_of(data)
    return np.add.reduceat(points[connectivity], offsets[:-1]) / np.diff(offsets)[:, None]
