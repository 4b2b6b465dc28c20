"""MetaImage (.mha, .mhd) and NRRD (.nrrd, .nhdr), whose headers have the directions of the axes.

The first axis varies fastest. pynrrd reads both formats; a MetaImage header is first converted to one of
NRRD, because VTK's reader crashes on labels of 64 bits and ITK is a large dependency. Source: the
documentation of MetaIO in ITK's wiki.
"""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from itertools import permutations
from pathlib import Path
from typing import IO, Any

import numpy as np

from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.extras import extra
from craftmesh.io.file_volume import FileVolume
from craftmesh.io.header_checks import DEFLATE, HEAD, data_file, refuse_false_size, unpacked

# Largest component of a voxel step off its axis, relative to the step, that counts as rounding: headers
# have six digits. Over 1000 voxels this adds up to a tenth of a voxel.
ALIGNED = 1e-4
# Names of number types in NRRD, by their names in MetaIO.
_TYPES = {"CHAR": "int8", "UCHAR": "uint8", "SHORT": "int16", "USHORT": "uint16", "INT": "int32"}
_TYPES |= {"UINT": "uint32", "LONG": "long", "ULONG": "ulong", "LONG_LONG": "int64", "ULONG_LONG": "uint64"}
_TYPES |= {"FLOAT": "float", "DOUBLE": "double"}
_LONG = {"long": ("int32", "int64"), "ulong": ("uint32", "uint64")}
_LAST = "ElementDataFile"  # the header's last key, after which the data begin
_NRRD_FILES = ("datafile", "data file")
_METHODS = {"gzip": "deflate", "gz": "deflate", "bzip2": "bzip2", "bz2": "bzip2"}


def along_axes(
    path: str | os.PathLike, labels: np.ndarray, steps: np.ndarray, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return labels (nx, ny, nz) along x, y, z, their spacing (3,) and the lower corner of their box (3,).

    labels: with the file's axes; steps (3, 3): row k is the vector from one voxel to the next along axis k;
    first (3,): centre of the first voxel. Reversed or permuted axes are put in order. Raises CraftmeshError
    for axes not parallel to x, y, z, and if the labels do not have three axes.
    """
    if labels.ndim != 3 or steps.shape != (3, 3):
        raise CraftmeshError(
            f"{path}: has {labels.ndim} axes; export a volume of three axes, with one label per voxel"
        )
    if not (np.isfinite(steps).all() and np.isfinite(first).all() and steps.any(axis=1).all()):
        raise CraftmeshError(
            f"{path}: voxel steps are {rounded_values(steps)}, the origin is {rounded_values(first)}; "
            "expected finite numbers, and a spacing that is not 0"
        )
    order = next((list(p) for p in permutations(range(3)) if _is_diagonal(steps[list(p)])), None)
    if order is None:
        raise CraftmeshError(
            f"{path}: its axes are oblique (voxel steps {rounded_values(steps)}); resample it on axes x, "
            f"y, z"
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
    return bool((along != 0).all() and (aside <= ALIGNED * np.abs(along)).all())


def read_metaimage(path: str | os.PathLike) -> FileVolume:
    """Read the labels, ElementSpacing (else ElementSize), TransformMatrix and Offset.

    Offset is the centre of the first voxel; without it the origin is None. MET_LONG is read as 8 bytes if
    the data are long enough, else as 4, because its size depends on the system that wrote it. Raises
    CraftmeshError for damaged or incomplete files, several numbers per voxel, and oblique axes.
    """
    path = Path(path)
    with open(path, "rb") as stream:
        header, rest = _header(path, stream), stream.read()
    shape = _header_numbers(path, header, ("DimSize",), np.int64)
    if shape is None or len(shape) != 3 or (shape <= 0).any():
        raise CraftmeshError(f"{path}: DimSize is {header.get('DimSize')}; expected three voxel counts")
    if header.get("ElementNumberOfChannels", "1") != "1":
        raise CraftmeshError(f"{path}: has several numbers per voxel; export one label per voxel")
    kind = header.get("ElementType", "").removeprefix("MET_")
    if kind not in _TYPES:
        raise CraftmeshError(
            f"{path}: ElementType is {header.get('ElementType')}; "
            f"expected one of MET_{', MET_'.join(_TYPES)}"
        )
    for other in _metaimage_data(path, header):
        rest = other.read_bytes()
    skip = _header_numbers(path, header, ("HeaderSize",), np.int64)  # -1: the data are the end of the file
    before = 0 if skip is None else int(skip[0])
    is_packed = header.get("CompressedData", "False").lower() == "true"
    is_text = header.get("BinaryData", "True").lower() == "false"
    big = header.get("BinaryDataByteOrderMSB", header.get("ElementByteOrderMSB", "False"))
    as_nrrd = {"dimension": 3, "sizes": shape, "type": _TYPES[kind], "byte skip": min(before, 0)}
    as_nrrd["endian"] = "big" if big.lower() == "true" else "little"
    as_nrrd["encoding"] = "gzip" if is_packed else "text" if is_text else "raw"
    labels = _labels(path, as_nrrd, rest[max(before, 0) :])
    spacing = _header_numbers(path, header, ("ElementSpacing", "ElementSize"), float, 3)
    first = _header_numbers(path, header, ("Offset", "Position", "Origin"), float, 3)
    turn = _header_numbers(path, header, ("TransformMatrix", "Rotation", "Orientation"), float, 9)
    directions = np.eye(3) if turn is None else turn.reshape(3, 3)
    if spacing is None:
        return FileVolume(_placed(path, labels, directions, None).labels)
    return _placed(path, labels, directions * spacing[:, None], first)


def _placed(path: Path, labels: np.ndarray, steps: np.ndarray, first: np.ndarray | None) -> FileVolume:
    """Return the volume with axes x, y, z.

    steps (3, 3): row k is the vector between voxels along the file's axis k; first (3,): centre of the
    first voxel, None if unknown. Raises CraftmeshError for oblique axes.
    """
    turned, spacing, corner = along_axes(path, labels, steps, np.zeros(3) if first is None else first)
    return FileVolume(turned, spacing, None if first is None else corner)


def metaimage_data(path: Path) -> list[Path]:
    """Return the data file of a .mhd in a list, [] for a .mha; raises CraftmeshError if it is missing."""
    with open(path, "rb") as stream:
        return _metaimage_data(path, _header(path, stream))


def _metaimage_data(path: Path, header: Mapping[str, str]) -> list[Path]:
    return [] if header[_LAST].upper() == "LOCAL" else [data_file(path, _LAST, header[_LAST])]


def _header(path: Path, stream: IO[bytes]) -> dict[str, str]:
    """Return the header's values by key; the stream then stands at the first byte after the header."""
    header: dict[str, str] = {}
    while _LAST not in header:
        line = stream.readline(HEAD).decode("ascii", "replace").removesuffix("\n")
        key, equals, value = line.partition("=")
        if not equals:
            raise CraftmeshError(
                f"{path}: {line[:40]!r} is not a line of a MetaImage header; "
                f"write lines KEY = VALUE up to {_LAST}"
            )
        header[key.strip()] = value.strip()
    return header


def _header_numbers(
    path: Path, header: Mapping[str, str], names: tuple[str, ...], kind: type, count: int = 0
) -> np.ndarray | None:
    """Return the numbers of the first key in `names` that the header has; None if it has no such key.

    kind: number type; count: required number of values, 0 for any number. Raises CraftmeshError for other
    values.
    """
    for name in names:
        if name in header:
            try:
                numbers: np.ndarray = np.array(header[name].split(), kind)
            except (ValueError, OverflowError):
                numbers = np.zeros(0)
            if not numbers.size or count not in (0, numbers.size):
                raise CraftmeshError(f"{path}: {name} is {header[name]!r}; write {count or 'only'} numbers")
            return numbers
    return None


def read_nrrd(path: str | os.PathLike) -> FileVolume:
    """Read the labels and, if present, `space directions` and `space origin`, or `spacings`.

    The format's origin is the centre of the first voxel. Raises CraftmeshError for damaged or incomplete
    files and for oblique axes.
    """
    with extra("formats"):
        import nrrd

    path = Path(path)
    with _told(path), open(path, "rb") as stream:
        header = nrrd.read_header(stream)
        labels = _labels(path, header, stream.read())
    steps = _steps(header, labels.ndim)
    if steps is None:
        return FileVolume(_placed(path, labels, np.eye(labels.ndim), None).labels)
    return _placed(path, labels, steps, _numbers(header.get("space origin"), 3))


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Turn any exception of pynrrd and its decoders into a CraftmeshError that names the file."""
    try:
        yield
    except (CraftmeshError, MemoryError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split())
        raise CraftmeshError(f"{path}: is damaged or incomplete ({reason}); export it again") from None


def nrrd_data(path: Path) -> list[Path]:
    """Return the data files of a .nhdr, [] for a .nrrd; raises CraftmeshError if one is missing."""
    with extra("formats"):
        import nrrd

    with _told(path), open(path, "rb") as stream:
        return _nrrd_data(path, nrrd.read_header(stream))


def _nrrd_data(path: Path, header: Mapping[str, Any]) -> list[Path]:
    return [data_file(path, key, header[key]) for key in _NRRD_FILES if key in header]


def _labels(path: Path, header: dict[str, Any], rest: bytes) -> np.ndarray:
    """Return the labels that an NRRD header describes, from its data file if it has one, else from `rest`.

    rest: the file's bytes after the header. Only as many bytes as needed are unpacked. Changes `header` in
    place: keys for the location and compression of the data are removed or replaced.
    """
    with extra("formats"):
        import nrrd

    for other in _nrrd_data(path, header):
        rest = other.read_bytes()
    for key in _NRRD_FILES:
        header.pop(key, None)
    lines = sum(header.pop(key, 0) for key in ("lineskip", "line skip"))
    rest = rest.split(b"\n", lines)[lines]
    method = _METHODS.get(header["encoding"])
    ratio = DEFLATE if method == "deflate" else None if method else 1
    count = refuse_false_size(path, "sizes", header["sizes"], 1, len(rest), ratio)
    if method is not None:
        header["encoding"] = "raw"
        skip = max(0, *(header.get(key, 0) for key in ("byteskip", "byte skip")))
        most = np.dtype(float).itemsize * count + refuse_false_size(path, "byte skip", [skip], 1, 0, None)
        rest = unpacked(path, rest, most, method)
    if header["type"] in _LONG:
        header["type"] = _LONG[header["type"]][len(rest) >= 8 * count]
    with _told(path):
        return nrrd.read_data(header, BytesIO(rest), index_order="F")


def _steps(header: Mapping[str, Any], axes: int) -> np.ndarray | None:
    """Return the voxel steps (3, 3), row k along axis k; None if the header has none."""
    directions = header.get("space directions")
    if directions is not None and np.shape(directions) == (3, 3):
        return np.asarray(directions, float)
    spacings = _numbers(header.get("spacings"), axes)
    return np.diag(spacings) if spacings is not None and axes == 3 else None


def _numbers(values: Any, count: int) -> np.ndarray | None:
    if values is None or np.shape(values) != (count,) or not np.isfinite(values).all():
        return None
    return np.asarray(values, float)
