"""Protection against damaged files: sizes in headers are checked against the file and the memory."""

import bz2
import logging
import lzma
import math
import os
import resource
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from craftmesh.errors import CraftmeshError, existing_file, named
from craftmesh.extras import extra

DEFLATE = 1032  # largest ratio of unpacked to packed bytes in zlib's method: 258 bytes in two bits
HEAD = 1 << 16  # bytes at the start of a file that are searched for its header
_GIGABYTE = 1e9


def _lz4_block(packed: bytes | memoryview, size: int) -> bytes:
    with extra("formats"):
        from lz4.block import LZ4BlockError, decompress
    try:
        return decompress(packed, size)
    except LZ4BlockError as error:
        raise ValueError(error) from None


_METHODS: dict[str, Callable[[bytes | memoryview, int], bytes]] = {
    "deflate": lambda *data: zlib.decompressobj(wbits=47).decompress(*data),  # zlib or gzip data
    "bzip2": lambda *data: bz2.BZ2Decompressor().decompress(*data),
    "lzma": lambda *data: lzma.LZMADecompressor().decompress(*data),
    "lz4": _lz4_block,
}


def refuse_false_size(
    path: str | os.PathLike,
    what: str,
    shape: Iterable[int],
    itemsize: int,
    there: int,
    ratio: int | None = 1,
) -> int:
    """Return the size in bytes of an array that a header declares, if the file can contain it.

    what: the array's name, for errors; itemsize: bytes per value; there: bytes stored in the file; ratio:
    largest ratio of unpacked to stored bytes, None if unlimited. Raises CraftmeshError for a negative
    count, for a size that the file cannot contain, and for a size above `memory_limit`.
    """
    counts = [int(count) for count in shape]
    size = math.prod(counts) * itemsize
    if min(counts, default=0) < 0 or (ratio is not None and size > there * ratio):
        raise CraftmeshError(
            f"{path}: {what} of shape {tuple(counts)} needs {size} bytes, but the file has {there} for it; "
            "it is truncated or its header is wrong, copy it again"
        )
    if size > memory_limit():
        raise CraftmeshError(
            f"{path}: {what} of shape {tuple(counts)} needs {size / _GIGABYTE:.1f} GB, but the memory here "
            f"is {memory_limit() / _GIGABYTE:.1f} GB; crop it or use a larger machine"
        )
    return size


def memory_limit() -> int:
    """Return the bytes that this process may use: the machine's memory, or `ulimit -v` if that is less."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    return machine if allowed == resource.RLIM_INFINITY else min(machine, allowed)


@contextmanager
def enough_memory(path: str | os.PathLike) -> Iterator[None]:
    """Turn a MemoryError in the block into a CraftmeshError that names the file."""
    try:
        yield
    except MemoryError:
        raise CraftmeshError(
            f"{path}: needs more than the memory here, {memory_limit() / _GIGABYTE:.1f} GB; crop it or "
            "use a larger machine"
        ) from None


def refuse_false_zip(path: str | os.PathLike) -> None:
    """Raise CraftmeshError if the entries of a zip archive are larger than it can contain, or than memory.

    Raises zipfile.BadZipFile if the file is not a zip archive.
    """
    with zipfile.ZipFile(path) as archive:
        entries = archive.infolist()
    is_bounded = all(entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for entry in entries)
    size = sum(entry.file_size for entry in entries)
    refuse_false_size(
        path, "its content", [size], 1, os.path.getsize(path), DEFLATE if is_bounded else None
    )


def unpacked(path: str | os.PathLike, packed: bytes | memoryview, size: int, method: str) -> bytes:
    """Return at most the first `size` bytes of the unpacked data; nothing more is unpacked.

    method: the compression, a key of _METHODS. Raises CraftmeshError for damaged data.
    """
    try:
        return _METHODS[method](packed, size) if size else b""
    except (zlib.error, lzma.LZMAError, OSError, EOFError, ValueError) as error:
        raise CraftmeshError(f"{path}: its data cannot be unpacked ({error}); save it again") from None


def data_file(header: Path, key: str, name: str) -> Path:
    """Return the path of the data file `name` that the file `header` has under `key`.

    Raises CraftmeshError if the data file is missing, if `name` is a list or pattern of files, or if the
    data file is not in the header's folder or below it.
    """
    if name.split()[:1] == ["LIST"] or "%" in name:
        raise CraftmeshError(f"{header}: its data are in one file per slice; save it as one .mha or .nrrd")
    other = header.parent / name
    if not other.exists():
        raise CraftmeshError(f"{header}: {key} {other} is missing; put it next to the header")
    with named(f"{header}: {key}"):
        existing_file(other, "expected a data file")
    homes = {header.parent.resolve(), header.resolve().parent}
    if not any(other.resolve().is_relative_to(home) for home in homes):
        raise CraftmeshError(
            f"{header}: {key} {name} is outside the header's folder; move it there and edit the header"
        )
    return other


@contextmanager
def heard(library: str) -> Iterator[list[str]]:
    """Yield a list of texts that grows by each warning or error that a library logs within the block."""
    said: list[str] = []
    listener = logging.Handler(logging.WARNING)
    listener.emit = lambda record: said.append(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger(library)
    logger.addHandler(listener)
    try:
        yield said
    finally:
        logger.removeHandler(listener)
