"""Files that may be false: what a header declares, held against the bytes there; what libraries log."""

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

DEFLATE = 1032  # bytes of one: the most that zlib's method packs, 258 bytes in two bits
HEAD = 1 << 16  # bytes at a file's start in which what it declares is looked for
_GIGABYTE = 1e9


def _lz4_block(packed: bytes | memoryview, size: int) -> bytes:
    with extra("formats"):
        from lz4.block import LZ4BlockError, decompress
    try:
        return decompress(packed, size)
    except LZ4BlockError as error:
        raise ValueError(error) from None


_METHODS: dict[str, Callable[[bytes | memoryview, int], bytes]] = {
    "deflate": lambda *data: zlib.decompressobj(wbits=47).decompress(*data),  # of zlib or gzip
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
    """Return the bytes of an array of `shape` that a header declares, if the file can hold them.

    there: the bytes stored; ratio: how many one stored byte may stand for, None where nothing bounds it.
    Raises CraftmeshError for a false size, and for one beyond the memory of this machine or process.
    """
    counts = [int(count) for count in shape]
    size = math.prod(counts) * itemsize
    if min(counts, default=0) < 0 or (ratio is not None and size > there * ratio):
        raise CraftmeshError(
            f"{path}: {what} of shape {tuple(counts)} takes {size} bytes, and the file has {there} for it; "
            "it was cut short or its head is false, copy it anew"
        )
    if size > memory_limit():
        raise CraftmeshError(
            f"{path}: {what} of shape {tuple(counts)} takes {size / _GIGABYTE:.1f} GB; expected at most "
            f"the memory here, {memory_limit() / _GIGABYTE:.1f} GB: crop it or take a larger machine"
        )
    return size


def memory_limit() -> int:
    """Return the bytes that this process may take: the machine's memory, or what `ulimit -v` leaves."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    return machine if allowed == resource.RLIM_INFINITY else min(machine, allowed)


@contextmanager
def enough_memory(path: str | os.PathLike) -> Iterator[None]:
    """Turn a lack of memory within into a CraftmeshError that names the file."""
    try:
        yield
    except MemoryError:
        raise CraftmeshError(
            f"{path}: takes more than the memory here, {memory_limit() / _GIGABYTE:.1f} GB; crop it or "
            "take a larger machine"
        ) from None


def refuse_false_zip(path: str | os.PathLike) -> None:
    """Refuse a zip archive whose entries are larger than what it can hold, or than memory.

    Raises CraftmeshError, and zipfile.BadZipFile for another file.
    """
    with zipfile.ZipFile(path) as archive:
        entries = archive.infolist()
    is_bounded = all(entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for entry in entries)
    size = sum(entry.file_size for entry in entries)
    refuse_false_size(
        path, "its content", [size], 1, os.path.getsize(path), DEFLATE if is_bounded else None
    )


def unpacked(path: str | os.PathLike, packed: bytes | memoryview, size: int, method: str) -> bytes:
    """Return the first `size` bytes, or as many as there are, of what `method` packed, a key of _METHODS.

    No more are unpacked. Raises CraftmeshError for broken data.
    """
    try:
        return _METHODS[method](packed, size) if size else b""
    except (zlib.error, lzma.LZMAError, OSError, EOFError, ValueError) as error:
        raise CraftmeshError(f"{path}: its data cannot be unpacked ({error}); save it anew") from None


def data_file(header: Path, key: str, name: str) -> Path:
    """Return the file of data that a header names, which lies in the header's own folder or below it.

    Raises CraftmeshError for another place, lists of files, and one that is missing.
    """
    if name.split()[:1] == ["LIST"] or "%" in name:
        raise CraftmeshError(f"{header}: its data are a file a slice; save it as one .mha or .nrrd")
    other = header.parent / name
    if not other.exists():
        raise CraftmeshError(f"{header}: {key} {other} is missing; put it beside the header")
    with named(f"{header}: {key}"):
        existing_file(other, "expected a file of data")
    homes = {header.parent.resolve(), header.resolve().parent}
    if not any(other.resolve().is_relative_to(home) for home in homes):
        raise CraftmeshError(
            f"{header}: {key} {name} lies outside the header's folder; move it there and name it so"
        )
    return other


@contextmanager
def heard(library: str) -> Iterator[list[str]]:
    """Yield the list that gets the warnings and errors which a library logs within."""
    said: list[str] = []
    listener = logging.Handler(logging.WARNING)
    listener.emit = lambda record: said.append(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger(library)
    logger.addHandler(listener)
    try:
        yield said
    finally:
        logger.removeHandler(listener)
