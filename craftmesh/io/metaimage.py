"""MetaImage volumes: .mha, or a header .mhd with its data in other files; x runs fastest.

VTK's reader crashes on labels of 64 bits, and ITK is too large to carry for a header of a dozen lines.
Source: the documentation of MetaIO in the wiki of ITK.
"""

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.declared import DEFLATE, data_file, refuse_false_size, unpacked
from craftmesh.io.file_volume import FileVolume, ids_in_text
from craftmesh.io.oriented import along_axes

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


def read(path: str | os.PathLike) -> FileVolume:
    """Read the labels, ElementSpacing (else ElementSize), TransformMatrix and Offset.

    The format's Offset is the centre of the first voxel; without it the origin is None. MET_LONG has 8
    bytes where the data are that long, as some systems write it. Raises CraftmeshError.
    """
    path = Path(path)
    header, rest = _header(path)
    shape = _numbers(path, header, ("DimSize",), np.int64)
    if shape is None or len(shape) != 3 or (shape <= 0).any():
        raise CraftmeshError(f"{path}: DimSize is {header.get('DimSize')}; expected three counts of voxels")
    if header.get("ElementNumberOfChannels", "1") != "1":
        raise CraftmeshError(f"{path}: has several numbers a voxel; expected one label a voxel")
    counts = [int(n) for n in shape]
    labels = _labels(path, header, _content(path, header, rest, counts), counts)
    spacing = _numbers(path, header, ("ElementSpacing", "ElementSize"), float, 3)
    first = _numbers(path, header, ("Offset", "Position", "Origin"), float, 3)
    turn = _numbers(path, header, ("TransformMatrix", "Rotation", "Orientation"), float, 9)
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
    size = _numbers(path, header, ("HeaderSize",), np.int64)
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


def _numbers(
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
