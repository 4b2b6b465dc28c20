"""The arrays of a VTK XML file: text, base64 or raw, inline or appended, compressed or not.

VTK's own readers are not used: they allocate any size that a header declares, and crash at a wrong count.
Source: "VTK XML Formats" in the documentation of VTK.
"""

import base64
import math
import mmap
import os
import re
from itertools import accumulate, pairwise
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from craftmesh.io.header_checks import DEFLATE, refuse_false_size, unpacked

_TYPES = {f"{'U' * (k == 'u')}Int{8 * n}": f"{k}{n}" for k in "iu" for n in (1, 2, 4, 8)}
_TYPES |= {"Float32": "f4", "Float64": "f8"}
TYPE_NAMES = {kind: name for name, kind in _TYPES.items()}
_METHODS = {
    "vtkZLibDataCompressor": "deflate",
    "vtkLZMADataCompressor": "lzma",
    "vtkLZ4DataCompressor": "lz4",
}
# Largest ratio of unpacked to packed size, by compression method; None: unlimited.
_RATIOS = {"": 1, "deflate": DEFLATE, "lzma": None, "lz4": 255}
_APPENDED = b"<AppendedData"


class VtkFile:
    """A VTK XML file, open for reading.

    whole: the XML element of the dataset; piece: the element of its only piece. Constructor and `arrays`
    raise ValueError, LookupError and the like if the file breaks the format, and CraftmeshError for arrays
    larger than the file can contain.
    """

    def __init__(self, path: str | os.PathLike, kind: str):
        self.path = path
        with open(path, "rb") as stream:
            content = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
        start = content.find(_APPENDED)
        head = content[:start] + b"</VTKFile>" if start >= 0 else content[:]
        root = ElementTree.fromstring(head)
        whole = root.find(kind)
        if root.tag != "VTKFile" or root.get("type") != kind or whole is None:
            raise ValueError(f"its type is {root.get('type')}")
        pieces = whole.findall("Piece")
        if len(pieces) != 1:
            raise ValueError(f"{len(pieces)} pieces, expected one: join them in ParaView")
        self.whole, self.piece = whole, pieces[0]
        self._order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self._word = np.dtype(self._order + ("u8" if root.get("header_type") == "UInt64" else "u4"))
        self._method = _METHODS[root.get("compressor", "")] if root.get("compressor") else ""
        self._appended = memoryview(b"")
        if start >= 0:
            tag_end = content.find(b">", start)
            self._is_raw = b"base64" not in content[start:tag_end]
            self._appended = memoryview(content)[content.find(b"_", tag_end) + 1 :]

    def arrays(self, section: str, count: int | None = None) -> dict[str, np.ndarray]:
        """Return the arrays (count,) or (count, c) of numbers in a section, such as CellData, by name.

        If `count` is None, each array has the number of rows in its header, else as many as its data fill.
        Arrays of text are left out.
        """
        above = self.whole if section == "FieldData" else self.piece
        elements = [element for part in above.findall(section) for element in part]
        numbers = [element for element in elements if element.get("type") in _TYPES]
        return {element.get("Name", section): self._array(element, count) for element in numbers}

    def _array(self, element: Element, count: int | None) -> np.ndarray:
        dtype = np.dtype(self._order + _TYPES[element.attrib["type"]])
        width = int(element.get("NumberOfComponents", 1))
        if count is None and element.get("NumberOfTuples"):
            count = int(element.attrib["NumberOfTuples"])
        if element.get("format") == "ascii":
            values = np.array((element.text or "").split(), dtype.newbyteorder("="))
        else:
            values = np.frombuffer(self._bytes(element), dtype)
        if width < 1 or len(values) % width or (count is not None and len(values) != count * width):
            due = f"{'any' if count is None else count} times {width}"
            raise ValueError(f"{element.get('Name')} holds {len(values)} numbers, expected {due}")
        values = values.astype(dtype.newbyteorder("="))
        return values.reshape(-1, width) if width > 1 else values

    def _bytes(self, element: Element) -> bytes | memoryview:
        """Return the decoded bytes of an array that is stored as base64 or raw."""
        if element.get("format") == "appended":
            source = self._appended[int(element.attrib["offset"]) :]
            is_raw = self._is_raw
        else:
            source, is_raw = memoryview(re.sub(rb"\s", b"", (element.text or "").encode())), False
        if not len(source):
            return b""
        return self._unpacked(source, is_raw) if self._method else self._plain(source, is_raw)

    def _plain(self, source: memoryview, is_raw: bool) -> bytes | memoryview:
        size = int(np.frombuffer(_taken(source, self._word.itemsize, is_raw), self._word, 1)[0])
        return _taken(source, self._word.itemsize + size, is_raw)[self._word.itemsize :]

    def _unpacked(self, source: memoryview, is_raw: bool) -> bytes:
        """Return the unpacked bytes of all blocks.

        The blocks' header has the number of blocks, the size of a full block, the size of a last block that
        is shorter (else 0), and the packed size of each block.
        """
        count = int(np.frombuffer(_taken(source, self._word.itemsize, is_raw), self._word, 1)[0])
        if not count:
            return b""
        head_size = (3 + count) * self._word.itemsize
        _, block, last, *lengths = np.frombuffer(_taken(source, head_size, is_raw), self._word).tolist()
        sizes = [block] * (count - bool(last)) + [last] * bool(last)
        ratio = _RATIOS[self._method]
        refuse_false_size(self.path, "an array", [sum(sizes)], 1, sum(lengths), ratio)
        data = _taken(source[_stored(head_size, is_raw) :], sum(lengths), is_raw)
        bounds = pairwise(accumulate(lengths, initial=0))
        blocks = [(data[a:b], size) for (a, b), size in zip(bounds, sizes, strict=True)]
        return b"".join(unpacked(self.path, *block, self._method) for block in blocks)


def _stored(size: int, is_raw: bool) -> int:
    """Return the number of stored characters for `size` bytes, raw or as base64."""
    return size if is_raw else 4 * math.ceil(size / 3)


def _taken(source: memoryview, size: int, is_raw: bool) -> bytes | memoryview:
    """Return the first `size` decoded bytes; raises ValueError if there are fewer."""
    stored = source[: _stored(size, is_raw)]
    part = stored if is_raw else base64.b64decode(stored, validate=True)[:size]
    if len(part) < size:
        raise ValueError(f"an array has {len(part)} of {size} bytes")
    return part
