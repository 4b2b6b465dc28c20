"""VTK XML files: arrays in, arrays out; vtkmodules is imported on first use."""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError

if TYPE_CHECKING:
    from vtkmodules.vtkCommonCore import vtkDataArray, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkDataObject, vtkFieldData, vtkPointSet
    from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm

_COMPRESSION = (
    1  # connectivity shrinks 4-fold at level 1 and hardly more at level 5, which takes thrice as long
)


def add_arrays(attributes: "vtkFieldData", arrays: Mapping[str, np.ndarray]) -> None:
    """Add named arrays (k,) or (k, c) to the point, cell or field data `attributes`."""
    for name, values in arrays.items():
        array = as_vtk(values)
        array.SetName(name)
        attributes.AddArray(array)


def as_vtk(values: np.ndarray) -> "vtkDataArray":
    """Return `values` (k,) or (k, c) as a VTK array of the same type and bits."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    return numpy_to_vtk(np.ascontiguousarray(values), deep=True)


def as_numpy(array: "vtkDataArray") -> np.ndarray:
    """Return a VTK array's values as a numpy array (k,) or (k, c) that owns its memory."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return np.array(vtk_to_numpy(array))


def cell_array(connectivity: np.ndarray, offsets: np.ndarray) -> "vtkCellArray":
    """Return a vtkCellArray of the cells connectivity[offsets[i] : offsets[i + 1]]."""
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    cells = vtkCellArray()
    ids = [
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(a, np.int64), deep=True)
        for a in (offsets, connectivity)
    ]
    cells.SetData(*ids)
    return cells


def uniform_cells(cells: np.ndarray) -> "vtkCellArray":
    """Return the rows of `cells` (m, k) as a vtkCellArray."""
    m, k = cells.shape
    return cell_array(cells.ravel(), np.arange(0, m * k + 1, k))


def cells_of(cells: "vtkCellArray") -> tuple[np.ndarray, np.ndarray]:
    """Return connectivity and offsets of a vtkCellArray."""
    if not cells.GetNumberOfCells():
        return np.zeros(0, np.int64), np.zeros(1, np.int64)
    return as_numpy(cells.GetConnectivityArray()), as_numpy(cells.GetOffsetsArray())


def vtk_points(points: np.ndarray) -> "vtkPoints":
    """Return vtkPoints that hold `points` (n, 3) in float64."""
    from vtkmodules.vtkCommonCore import vtkPoints

    result = vtkPoints()
    result.SetDataTypeToDouble()
    result.SetData(as_vtk(np.asarray(points, float)))
    return result


def points_of(dataset: "vtkPointSet") -> np.ndarray:
    """Return the points (n, 3) of a data set; none when it has none."""
    points = dataset.GetPoints()
    return np.zeros((0, 3)) if points is None else as_numpy(points.GetData())


def write_dataset(path: str | os.PathLike, dataset: "vtkDataObject", kind: str) -> None:
    """Write `dataset` as VTK XML of `kind` (PolyData, ImageData, UnstructuredGrid), zlib-compressed.

    The same data set gives the same bytes. Raises CraftmeshError where the file cannot be written.
    """
    from vtkmodules import vtkIOXML
    from vtkmodules.vtkIOCore import vtkZLibDataCompressor

    writer = getattr(vtkIOXML, f"vtkXML{kind}Writer")()
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetHeaderTypeToUInt64()
    compressor = vtkZLibDataCompressor()
    compressor.SetCompressionLevel(_COMPRESSION)
    writer.SetCompressor(compressor)
    writer.SetInputData(dataset)
    faults = _collect_errors(writer)
    with atomic_path(path) as temporary, _without_messages():
        writer.SetFileName(os.fspath(temporary))
        if not writer.Write() or faults or writer.GetErrorCode():
            raise CraftmeshError(f"{path}: cannot be written; check the folder and the space left on it")


def read_dataset(path: str | os.PathLike, kind: str) -> Any:
    """Read a VTK XML file of `kind`; raises CraftmeshError if it is missing, broken or of another kind."""
    from vtkmodules import vtkIOXML

    if not Path(path).is_file():
        raise CraftmeshError(f"{path}: no such file; run the stage that writes it or give another path")
    reader = getattr(vtkIOXML, f"vtkXML{kind}Reader")()
    faults = _collect_errors(reader)
    with _without_messages():
        readable = reader.CanReadFile(os.fspath(path))
        if readable:
            reader.SetFileName(os.fspath(path))
            reader.Update()
    if not readable or faults or reader.GetErrorCode():
        raise CraftmeshError(f"{path}: not a whole VTK XML {kind} file; write it again")
    return reader.GetOutput()


def named_array(
    path: str | os.PathLike, attributes: "vtkFieldData", names: Sequence[str], where: str
) -> np.ndarray:
    """Return the first array of `names` there is in `attributes`; CraftmeshError names what is missing."""
    for name in names:
        array = attributes.GetArray(name)
        if array is not None:
            return as_numpy(array)
    found = ", ".join(attributes.GetArrayName(i) or "?" for i in range(attributes.GetNumberOfArrays()))
    wanted = " or ".join(repr(n) for n in names)
    raise CraftmeshError(f"{path}: no {where} {wanted} (found: {found or 'none'}); write it with craftmesh")


def field_array(dataset: "vtkDataObject", name: str) -> np.ndarray | None:
    """Return the field data array `name`, or None where there is none."""
    array = dataset.GetFieldData().GetArray(name)
    return None if array is None else as_numpy(array)


@contextmanager
def _without_messages() -> Iterator[None]:
    """Keep VTK from printing what is raised as CraftmeshError."""
    from vtkmodules.vtkCommonCore import vtkObject

    shown = vtkObject.GetGlobalWarningDisplay()
    vtkObject.SetGlobalWarningDisplay(0)
    try:
        yield
    finally:
        vtkObject.SetGlobalWarningDisplay(shown)


def _collect_errors(algorithm: "vtkAlgorithm") -> list:
    faults: list = []
    algorithm.AddObserver("ErrorEvent", lambda *_: faults.append(True))  # type: ignore[arg-type]
    return faults
