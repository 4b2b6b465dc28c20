"""Reading and writing of VTK XML files as sets of arrays."""

import math
import os
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from craftmesh.arguments import as_array
from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError, existing_file
from craftmesh.io.header_checks import enough_memory
from craftmesh.io.vtk_xml_file import TYPE_NAMES, VtkFile

# zlib's level: 1 packs connectivity 4-fold; 5 packs hardly more and takes three times as long.
_COMPRESSION = 1
_BLOCK = 1 << 20  # bytes per compressed block
_CELL_SIZES = {5: 3, 10: 4, 22: 6, 24: 10}  # nodes of triangles and tetrahedra, by VTK's cell type
Arrays = Mapping[str, np.ndarray]
NO_CELLS = (np.zeros(0, np.int64), np.zeros(1, np.int64))


@dataclass(frozen=True, eq=False)
class Dataset:
    """The content of a VTK XML file.

    at_points, at_cells, others: point, cell and field data, arrays (k,) or (k, c) by name; points (n, 3);
    cells: connectivity and offsets (which begin with 0) by section Verts, Lines, Strips, Polys or Cells;
    types (m,): VTK's cell types of a grid; place: extent (6,), steps (3,) (numbers of cells), spacing (3,),
    origin (3,) and direction (9,) of an image, and x, y, z (k,), the planes of a rectilinear grid.
    """

    at_points: Arrays = field(default_factory=dict)
    at_cells: Arrays = field(default_factory=dict)
    others: Arrays = field(default_factory=dict)
    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    cells: Mapping[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    types: np.ndarray = field(default_factory=lambda: np.zeros(0, np.uint8))
    place: Arrays = field(default_factory=dict)

    def centres(self, section: str) -> np.ndarray:
        """Return the means (m, 3) of the points of a section's cells."""
        corners, offsets = self.cells[section]
        return np.add.reduceat(self.points[corners], offsets[:-1]) / np.diff(offsets)[:, None]

    def elements(self, path: str | os.PathLike) -> np.ndarray:
        """Return the cells (m, k) of an unstructured grid as node ids.

        path: for errors. Raises CraftmeshError if the cells differ in their number of nodes, or if there
        are none.
        """
        connectivity, offsets = self.cells["Cells"]
        sizes = np.unique(np.diff(offsets))
        if len(sizes) != 1:
            raise CraftmeshError(
                f"{path}: has cells of {sizes.tolist()} nodes; give a mesh whose elements have one type"
            )
        return connectivity.reshape(-1, sizes[0])


def in_rows(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return connectivity (m k,) and offsets (m + 1,) of cells (m, k), all with k points."""
    return cells.ravel(), cells.shape[1] * np.arange(len(cells) + 1)


def write_dataset(path: str | os.PathLike, kind: str, data: Dataset) -> None:
    """Write a VTK XML file of `kind` PolyData, ImageData or UnstructuredGrid, one piece packed by zlib.

    The same data give the same bytes. Raises CraftmeshError if the file cannot be written.
    """
    head = {"type": kind, "version": "1.0", "byte_order": "LittleEndian", "header_type": "UInt64"}
    root = Element("VTKFile", head, compressor="vtkZLibDataCompressor")
    counts = {f"NumberOf{name}": len(offsets) - 1 for name, (_, offsets) in data.cells.items()}
    counts["NumberOfPoints"] = len(data.points)
    sections = {
        name: {"connectivity": _narrow(ids), "offsets": _narrow(at[1:])}
        for name, (ids, at) in data.cells.items()
    }
    if kind == "ImageData":
        place = {key.capitalize(): " ".join(map(str, row.tolist())) for key, row in data.place.items()}
        whole = SubElement(root, kind, place, WholeExtent=place["Extent"])
        piece = Element("Piece", Extent=place["Extent"])
    else:
        whole = SubElement(root, kind)
        piece = Element("Piece", {key: str(n) for key, n in counts.items()})
        sections["Points"] = {"Points": data.points}
    if kind == "UnstructuredGrid":
        sections["Cells"]["types"] = data.types
    packed: list[bytes] = []
    _add_section(whole, "FieldData", data.others, packed)
    whole.append(piece)
    for name, arrays in {"PointData": data.at_points, "CellData": data.at_cells, **sections}.items():
        _add_section(piece, name, arrays, packed)
    with atomic_path(path) as temporary, open(temporary, "wb") as stream:
        stream.write(tostring(root).removesuffix(b"</VTKFile>") + b'<AppendedData encoding="raw">_')
        stream.writelines(packed)
        stream.write(b"\n</AppendedData></VTKFile>\n")  # meshio needs these line ends


def _narrow(ids: np.ndarray) -> np.ndarray:
    """Return int64 ids as int32 if all fit, which halves the bytes to compress; else unchanged."""
    return ids.astype(np.int32) if ids.max(initial=0) <= np.iinfo(np.int32).max else ids


def _add_section(above: Element, name: str, arrays: Arrays, packed: list[bytes]) -> None:
    """Add a section of arrays (k,) or (k, c): their headers to `above`, their packed bytes to `packed`."""
    section = SubElement(above, name)
    for key, values in arrays.items():
        place = {"format": "appended", "offset": str(sum(map(len, packed)))}
        about = {"type": TYPE_NAMES[values.dtype.str[1:]], "Name": key, "NumberOfTuples": str(len(values))}
        about |= {"NumberOfComponents": str(values.shape[1])} if values.ndim > 1 else {}
        SubElement(section, "DataArray", about | place)
        content = values.astype(values.dtype.newbyteorder("<")).tobytes()
        blocks = [content[at : at + _BLOCK] for at in range(0, len(content), _BLOCK)]
        blocks = [zlib.compress(block, _COMPRESSION) for block in blocks]
        numbers = [len(blocks), _BLOCK, len(content) % _BLOCK, *map(len, blocks)]
        packed.append(b"".join([np.array(numbers, "<u8").tobytes(), *blocks]))


def read_dataset(path: str | os.PathLike, kind: str) -> Dataset:
    """Read a VTK XML file of one piece, `kind` PolyData, ImageData, RectilinearGrid or UnstructuredGrid.

    Raises CraftmeshError if the file is missing, damaged or of another kind, if counts, extents and data
    contradict each other, if cells refer to missing points, and if points are not finite.
    """
    existing_file(path, "run the stage that writes it or give another path")
    build = {"ImageData": _image, "RectilinearGrid": _planes, "PolyData": _poly, "UnstructuredGrid": _grid}
    try:
        with enough_memory(path):
            dataset = build[kind](VtkFile(path, kind))
    except (ValueError, LookupError, TypeError, ArithmeticError, SyntaxError) as error:
        raise CraftmeshError(
            f"{path}: is not an intact VTK XML {kind} file ({error}); write it again"
        ) from None
    as_array(f"{path}: points", dataset.points, float, (None, 3))
    return dataset


def _image(file: VtkFile) -> Dataset:
    extent, own = (_numbers(e, key, 6) for e, key in ((file.whole, "WholeExtent"), (file.piece, "Extent")))
    steps = [int(high - low) for low, high in zip(extent[::2], extent[1::2])]
    if min(steps) < 0 or own != extent:
        raise ValueError(f"its piece has the extent {own}, the whole file {extent}")
    points, cells = (math.prod(max(n + more, 1) for n in steps) for more in (1, 0))
    place = {"extent": np.array(extent, int), "steps": np.array(steps)}
    for key, default in (("Spacing", "1 1 1"), ("Origin", "0 0 0"), ("Direction", "1 0 0 0 1 0 0 0 1")):
        place[key.lower()] = np.array(_numbers(file.whole, key, len(default.split()), default))
    return Dataset(*_data(file, points, cells), place=place)


def _planes(file: VtkFile) -> Dataset:
    image = _image(file)
    planes = dict(zip("xyz", map(np.ravel, file.arrays("Coordinates").values())))
    if [len(at) for at in planes.values()] != (image.place["steps"] + 1).tolist():
        raise ValueError(f"{[len(at) for at in planes.values()]} planes do not fit the extent")
    return replace(image, place={**image.place, **planes})


def _poly(file: VtkFile) -> Dataset:
    points, cells = _points(file), {}
    for section in ("Verts", "Lines", "Strips", "Polys"):
        count = int(file.piece.get(f"NumberOf{section}", 0))
        cells[section] = _cells(file.arrays(section), count, len(points)) if count else NO_CELLS
    total = sum(len(offsets) - 1 for _, offsets in cells.values())
    return Dataset(*_data(file, len(points), total), points, cells)


def _grid(file: VtkFile) -> Dataset:
    points, count = _points(file), int(file.piece.get("NumberOfCells", 0))
    cells, types = NO_CELLS, np.zeros(0, np.uint8)
    if count:
        arrays = file.arrays("Cells")
        cells, types = _cells(arrays, count, len(points)), arrays["types"].astype(np.uint8)
        sizes = np.diff(cells[1])
        if len(types) != count or any((sizes[types == t] != n).any() for t, n in _CELL_SIZES.items()):
            raise ValueError(f"{len(types)} types do not fit {count} cells and their numbers of nodes")
    return Dataset(*_data(file, len(points), count), points, {"Cells": cells}, types)


def _numbers(element: Element, key: str, count: int, default: str | None = None) -> list[float]:
    text = element.attrib[key] if default is None else element.get(key, default)
    numbers = [float(word) for word in text.split()]
    if len(numbers) != count:
        raise ValueError(f"{key} is {text}, expected {count} numbers")
    return numbers


def _points(file: VtkFile) -> np.ndarray:
    count = int(file.piece.get("NumberOfPoints", 0))
    coordinates = [*file.arrays("Points", count).values(), np.zeros((0, 3))][0]
    if coordinates.shape != (count, 3):
        raise ValueError(f"Points have shape {coordinates.shape}, expected {count} points of three numbers")
    return coordinates


def _cells(arrays: Mapping[str, np.ndarray], count: int, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Return connectivity and offsets of `count` cells on `points` points; raises ValueError if invalid."""
    offsets = np.concatenate([[0], arrays["offsets"].astype(np.int64)])
    connectivity = arrays["connectivity"].astype(np.int64)[: max(offsets[-1], 0)]
    if len(offsets) != count + 1 or (np.diff(offsets) < 0).any() or len(connectivity) != offsets[-1]:
        raise ValueError(f"{len(offsets) - 1} offsets up to {offsets[-1]} do not fit {count} cells")
    if len(connectivity) and not 0 <= connectivity.min() <= connectivity.max() < points:
        raise ValueError(f"cells have points {connectivity.min()} to {connectivity.max()} of {points}")
    return connectivity, offsets


def _data(file: VtkFile, points: int, cells: int) -> tuple[Arrays, Arrays, Arrays]:
    return file.arrays("PointData", points), file.arrays("CellData", cells), file.arrays("FieldData")


def named_array(
    path: str | os.PathLike, arrays: Mapping[str, np.ndarray], names: Sequence[str], where: str
) -> np.ndarray:
    """Return the first of `names` in `arrays`; raises CraftmeshError if none is there.

    where: what the arrays are, such as "cell data", for the error.
    """
    for name in names:
        if name in arrays:
            return arrays[name]
    wanted, found = " or ".join(map(repr, names)), ", ".join(arrays) or "none"
    raise CraftmeshError(f"{path}: no {where} {wanted} (found: {found}); write it with craftmesh")
