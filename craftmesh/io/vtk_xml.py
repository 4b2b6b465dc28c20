"""VTK XML files: arrays in, arrays out; vtkmodules is imported on first use."""

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element

import numpy as np

from craftmesh.arguments import as_array
from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.io.declared import enough_memory
from craftmesh.io.vtk_xml_file import VtkFile

if TYPE_CHECKING:
    from vtkmodules.vtkCommonCore import vtkDataArray, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkDataObject, vtkFieldData, vtkPointSet

_COMPRESSION = (
    1  # connectivity shrinks 4-fold at level 1 and hardly more at level 5, which takes thrice as long
)

_CELL_SIZES = {5: 3, 10: 4, 22: 6, 24: 10}  # triangles and tetrahedra by VTK's number of the type


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


def rows_of(path: str | os.PathLike, cells: "vtkCellArray") -> np.ndarray:
    """Return cells of one size (m, k); raises CraftmeshError for others."""
    connectivity, offsets = cells_of(cells)
    sizes = np.unique(np.diff(offsets))
    if len(sizes) != 1:
        raise CraftmeshError(f"{path}: has cells of {sizes.tolist()} nodes; expected elements of one kind")
    return connectivity.reshape(-1, sizes[0])


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
    faults: list = []
    writer.AddObserver("ErrorEvent", lambda *_: faults.append(True))
    with atomic_path(path) as temporary, _without_messages():
        writer.SetFileName(os.fspath(temporary))
        if not writer.Write() or faults or writer.GetErrorCode():
            raise CraftmeshError(f"{path}: cannot be written; check the folder and the space left on it")


def read_dataset(path: str | os.PathLike, kind: str) -> Any:
    """Read a VTK XML file of `kind` (PolyData, ImageData, UnstructuredGrid) that is one piece.

    Raises CraftmeshError if it is missing, broken or of another kind, where counts, extents and data do not
    fit together, for cells of points that there are not, and for points that are not finite.
    """
    if not Path(path).is_file():
        raise CraftmeshError(f"{path}: no such file; run the stage that writes it or give another path")
    build = {"ImageData": _image, "PolyData": _poly, "UnstructuredGrid": _grid}[kind]
    try:
        with enough_memory(path), _without_messages():
            dataset: Any = build(VtkFile(path, kind))
    except (ValueError, LookupError, TypeError, ArithmeticError, SyntaxError) as error:
        raise CraftmeshError(f"{path}: not a whole VTK XML {kind} file ({error}); write it again") from None
    if kind != "ImageData":
        as_array(f"{path}: points", points_of(dataset), float, (None, 3))
    return dataset


def _image(file: VtkFile) -> "vtkDataObject":
    from vtkmodules.vtkCommonDataModel import vtkImageData

    extent, own = (_numbers(e, key) for e, key in ((file.whole, "WholeExtent"), (file.piece, "Extent")))
    steps = [int(high - low) for low, high in zip(extent[::2], extent[1::2], strict=True)]
    if len(steps) != 3 or min(steps) < 0 or own != extent:
        raise ValueError(f"extent {own} of {extent}")
    points, cells = (math.prod(max(n + more, 1) for n in steps) for more in (1, 0))
    data = _data(file, points, cells)
    if not (data["PointData"] or data["CellData"]):
        raise ValueError("no numbers at its points or cells")  # VTK would take memory for any extent
    image = vtkImageData()
    image.SetExtent(*map(int, extent))
    image.SetSpacing(*_numbers(file.whole, "Spacing", "1 1 1"))
    image.SetOrigin(*_numbers(file.whole, "Origin", "0 0 0"))
    image.SetDirectionMatrix(*_numbers(file.whole, "Direction", "1 0 0 0 1 0 0 0 1"))
    return _with_data(image, data)


def _poly(file: VtkFile) -> "vtkDataObject":
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    poly, points, total = vtkPolyData(), int(file.piece.get("NumberOfPoints", 0)), 0
    _set_points(poly, file, points)
    for section in ("Verts", "Lines", "Strips", "Polys"):
        count = int(file.piece.get(f"NumberOf{section}", 0))
        if count:
            getattr(poly, f"Set{section}")(_checked_cells(file.arrays(section), count, points))
        total += count
    return _with_data(poly, _data(file, points, total))


def _grid(file: VtkFile) -> "vtkDataObject":
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

    points, count = (int(file.piece.get(f"NumberOf{of}", 0)) for of in ("Points", "Cells"))
    grid = vtkUnstructuredGrid()
    _set_points(grid, file, points)
    if count:
        arrays = file.arrays("Cells")
        cells = _checked_cells(arrays, count, points)
        types, sizes = arrays["types"].astype(np.uint8), np.diff(cells_of(cells)[1])
        if len(types) != count or any((sizes[types == t] != n).any() for t, n in _CELL_SIZES.items()):
            raise ValueError(f"{len(types)} types of {count} cells, or nodes that do not fit them")
        grid.SetCells(as_vtk(types), cells)
    return _with_data(grid, _data(file, points, count))


def _numbers(element: Element, key: str, default: str | None = None) -> list[float]:
    text = element.attrib[key] if default is None else element.get(key, default)
    return [float(word) for word in text.split()]


def _set_points(dataset: "vtkPointSet", file: VtkFile, count: int) -> None:
    from vtkmodules.vtkCommonCore import vtkPoints

    coordinates = [*file.arrays("Points", count).values(), np.zeros((0, 3))][0]
    if coordinates.shape != (count, 3):
        raise ValueError(f"Points of shape {coordinates.shape}, expected {count} of three numbers")
    points = vtkPoints()
    points.SetData(as_vtk(coordinates))
    dataset.SetPoints(points)


def _checked_cells(arrays: Mapping[str, np.ndarray], count: int, points: int) -> "vtkCellArray":
    """Return cells whose offsets rise within the connectivity, and whose points there are."""
    offsets = np.concatenate([[0], arrays["offsets"].astype(np.int64)])
    connectivity = arrays["connectivity"].astype(np.int64)[: max(offsets[-1], 0)]
    if len(offsets) != count + 1 or (np.diff(offsets) < 0).any() or len(connectivity) != offsets[-1]:
        raise ValueError(f"{len(offsets) - 1} offsets up to {offsets[-1]} of {count} cells")
    if len(connectivity) and not 0 <= connectivity.min() <= connectivity.max() < points:
        raise ValueError(f"cells of points {connectivity.min()} to {connectivity.max()} of {points}")
    return cell_array(connectivity, offsets)


def _data(file: VtkFile, points: int, cells: int) -> dict[str, dict[str, np.ndarray]]:
    counts = {"PointData": points, "CellData": cells, "FieldData": None}
    return {where: file.arrays(where, count) for where, count in counts.items()}


def _with_data(dataset: Any, data: Mapping[str, Mapping[str, np.ndarray]]) -> "vtkDataObject":
    for where, arrays in data.items():
        add_arrays(getattr(dataset, f"Get{where}")(), arrays)
    return dataset


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
