"""MetaImage (.mha, .mhd) and NRRD (.nrrd, .nhdr): headers say where axes point; the first runs fastest.

VTK's reader of MetaImage crashes on labels of 64 bits, and ITK is too large to carry for a header of a
dozen lines. Source: the documentation of MetaIO in the wiki of ITK. NRRD is read by pynrrd.
"""

import math
import os
from collections.abc import Mapping, Sequence
from io import BytesIO
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.errors import CraftmeshError, told
from craftmesh.io.declared import DEFLATE, data_file, refuse_false_size, unpacked
from craftmesh.io.file_volume import FileVolume, ids_in_text

_ALIGNED = 1e-4  # of a step: headers have six digits, and over 1000 voxels this is a tenth of one
_TYPES = {
    "CHAR": "i1",
    "UCHAR": "u1",
    "SHORT": "i2",
    "USHORT": "u2",
    "INT": "i4",
    "UINT": "u4",
    "LONG": "i4",
    "ULONG": "u4",
    "LONG_LONG": "i8",
    "ULONG_LONG": "u8",
    "FLOAT": "f4",
    "DOUBLE": "f8",
}
_WIDEST = 8  # bytes of a number
_LAST = "ElementDataFile"  # the key after which the data begin
_METHODS = {"gzip": "deflate", "gz": "deflate", "bzip2": "bzip2", "bz2": "bzip2"}


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


def read_metaimage(path: str | os.PathLike) -> FileVolume:
    """Read the labels, ElementSpacing (else ElementSize), TransformMatrix and Offset.

    The format's Offset is the centre of the first voxel; without it the origin is None. MET_LONG has 8
    bytes where the data are that long, as some systems write it. Raises CraftmeshError.
    """
    path = Path(path)
    header, rest = _header(path)
    shape = _header_numbers(path, header, ("DimSize",), np.int64)
    if shape is None or len(shape) != 3 or (shape <= 0).any():
        raise CraftmeshError(f"{path}: DimSize is {header.get('DimSize')}; expected three counts of voxels")
    if header.get("ElementNumberOfChannels", "1") != "1":
        raise CraftmeshError(f"{path}: has several numbers a voxel; expected one label a voxel")
    counts = [int(n) for n in shape]
    labels = _labels(path, header, _content(path, header, rest, counts), counts)
    spacing = _header_numbers(path, header, ("ElementSpacing", "ElementSize"), float, 3)
    first = _header_numbers(path, header, ("Offset", "Position", "Origin"), float, 3)
    turn = _header_numbers(path, header, ("TransformMatrix", "Rotation", "Orientation"), float, 9)
    directions = np.eye(3) if turn is None else turn.reshape(3, 3)
    steps = directions * (np.ones(3) if spacing is None else spacing)[:, None]
    turned, lengths, corner = along_axes(path, labels, steps, np.zeros(3) if first is None else first)
    if spacing is None:
        return FileVolume(turned)
    return FileVolume(turned, lengths, None if first is None else corner)


def _header(path: Path) -> tuple[dict[str, str], bytes]:
    """Return the header's values by their keys, and what follows it in the file."""
    content = path.read_bytes()
    header: dict[str, str] = {}
    start = 0
    while _LAST not in header:
        end = content.find(b"\n", start)
        line = content[start : end if end >= 0 else len(content)].decode("ascii", "replace")
        key, equals, value = line.partition("=")
        if not equals:
            raise CraftmeshError(
                f"{path}: {line[:40]!r} is no line of a MetaImage header; "
                f"expected KEY = VALUE up to {_LAST}"
            )
        header[key.strip()] = value.strip()
        start = end + 1 if end >= 0 else len(content)
    return header, content[start:]


def _content(path: Path, header: Mapping[str, str], rest: bytes, shape: Sequence[int]) -> bytes:
    """Return the data behind the header or in the file that it names, unpacked as far as needed."""
    if header[_LAST].upper() != "LOCAL":
        rest = data_file(path, _LAST, header[_LAST]).read_bytes()
    size = _header_numbers(path, header, ("HeaderSize",), np.int64)
    rest = rest if size is None else rest[max(int(size[0]), 0) :]
    if header.get("CompressedData", "False").lower() != "true":
        return rest
    most = _WIDEST * refuse_false_size(path, "DimSize", shape, 1, len(rest), DEFLATE)
    return unpacked(path, rest, most, "deflate")


def _labels(path: Path, header: Mapping[str, str], content: bytes, shape: Sequence[int]) -> np.ndarray:
    kind = header.get("ElementType", "").removeprefix("MET_")
    if kind not in _TYPES:
        raise CraftmeshError(
            f"{path}: ElementType is {header.get('ElementType')}; "
            f"expected one of MET_{', MET_'.join(_TYPES)}"
        )
    count = math.prod(shape)
    if header.get("BinaryData", "True").lower() == "false":
        values = ids_in_text(path, content.split()[:count])
    else:
        kind = f"LONG_{kind}" if kind == "LONG" and len(content) >= 8 * count else kind
        kind = f"{kind}_LONG" if kind == "ULONG" and len(content) >= 8 * count else kind
        big = header.get("BinaryDataByteOrderMSB", header.get("ElementByteOrderMSB", "False"))
        dtype = np.dtype((">" if big.lower() == "true" else "<") + _TYPES[kind])
        ends_with = header.get("HeaderSize") == "-1"  # the data are the end of the file
        start = max(len(content) - count * dtype.itemsize, 0) if ends_with else 0
        whole = min(count, (len(content) - start) // dtype.itemsize)
        values = np.frombuffer(content, dtype, whole, start) if whole else np.zeros(0, dtype)
    if len(values) != count:
        raise CraftmeshError(
            f"{path}: has {len(values)} of {count} labels; the data are cut off, copy it anew"
        )
    return values.reshape(shape, order="F")


def _header_numbers(
    path: Path, header: Mapping[str, str], names: tuple[str, ...], kind: type, count: int = 0
) -> np.ndarray | None:
    """Return the numbers of the first of `names` that the header has, `count` of them; None without."""
    for name in names:
        if name in header:
            try:
                numbers: np.ndarray = np.array(header[name].split(), kind)
            except (ValueError, OverflowError):
                numbers = np.zeros(0)
            if not numbers.size or count not in (0, numbers.size):
                raise CraftmeshError(f"{path}: {name} is {header[name]!r}; expected {count or ''} numbers")
            return numbers
    return None


def read_nrrd(path: str | os.PathLike) -> FileVolume:
    """Read the labels with `space directions` and `space origin`, or `spacings`, where the header has them.

    The origin of the format is the centre of the first voxel. Raises CraftmeshError, also for oblique axes.
    """
    import nrrd

    try:
        with open(path, "rb") as stream:
            header = nrrd.read_header(stream)
            rest = stream.read()
        plain = _unpacked(Path(path), header, rest)
        labels = nrrd.read_data(header, BytesIO(plain), index_order="F")
    except (CraftmeshError, MemoryError):
        raise
    except Exception as error:  # pynrrd and the decoders that it calls raise many kinds
        reason = " ".join(str(error).split())
        raise CraftmeshError(f"{path}: is not a whole NRRD file ({reason}); export it anew") from None
    steps, has_spacing = _steps(header, labels.ndim)
    first = _numbers(header.get("space origin"), 3)
    turned, spacing, corner = along_axes(path, labels, steps, np.zeros(3) if first is None else first)
    if not has_spacing:
        return FileVolume(turned)
    return FileVolume(turned, spacing, None if first is None else corner)


def _unpacked(path: Path, header: dict[str, Any], rest: bytes) -> bytes:
    """Return the data behind the header or in the file that it names, unpacked as far as needed.

    The header loses what says where they were and how they were packed.
    """
    for key in ("datafile", "data file"):
        if key in header:
            rest = data_file(path, key, header.pop(key)).read_bytes()
    lines = sum(header.pop(key, 0) for key in ("lineskip", "line skip"))
    rest = rest.split(b"\n", lines)[lines]
    method = _METHODS.get(header["encoding"])
    ratio = DEFLATE if method == "deflate" else None if method else 1
    most = _WIDEST * refuse_false_size(path, "sizes", header["sizes"], 1, len(rest), ratio)
    if method is None:
        return rest
    header["encoding"] = "raw"
    skip = max(0, *(header.get(key, 0) for key in ("byteskip", "byte skip")))
    return unpacked(path, rest, most + refuse_false_size(path, "byte skip", [skip], 1, 0, None), method)


def _steps(header: Mapping[str, Any], axes: int) -> tuple[np.ndarray, bool]:
    """Return the step of each axis, a unit along its own where the header has none, and whether it has."""
    directions = header.get("space directions")
    if directions is not None and np.shape(directions) == (3, 3):
        return np.asarray(directions, float), True
    spacings = _numbers(header.get("spacings"), axes)
    if spacings is not None and axes == 3:
        return np.diag(spacings), True
    return np.eye(axes), False


def _numbers(values: Any, count: int) -> np.ndarray | None:
    if values is None or np.shape(values) != (count,) or not np.isfinite(values).all():
        return None
    return np.asarray(values, float)
