"""Fields of target lengths in .vtp and .vti files."""

from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml
from craftmesh.sizing.length_field import LengthField

_KINDS = {".vtp": "PolyData", ".vti": "ImageData"}


def read_length_field(path: Path, name: str) -> LengthField:
    """Read the array `name` of target lengths at the points or cells of a .vtp or .vti.

    Cell data count at the cells' centres. Raises CraftmeshError for other files, a missing array, one
    that is not a scalar, and lengths that are not finite and > 0.
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
    points = _points(data) if at_points else _centres(data)
    try:
        return LengthField(points, lengths)
    except CraftmeshError as error:
        raise CraftmeshError(f"{path}: {error}") from None


def _points(data) -> np.ndarray:
    if data.IsA("vtkPolyData"):
        return vtk_xml.points_of(data)
    return np.array([data.GetPoint(i) for i in range(data.GetNumberOfPoints())]).reshape(-1, 3)


def _centres(data) -> np.ndarray:
    bounds = np.array([data.GetCell(i).GetBounds() for i in range(data.GetNumberOfCells())])
    if data.IsA("vtkImageData"):
        return bounds.reshape(-1, 3, 2).mean(axis=2)
    connectivity, offsets = vtk_xml.cells_of(data.GetPolys())
    points = vtk_xml.points_of(data)
    return np.add.reduceat(points[connectivity], offsets[:-1]) / np.diff(offsets)[:, None]
