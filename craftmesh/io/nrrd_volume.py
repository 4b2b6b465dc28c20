"""NRRD volumes (.nrrd, .nhdr), read by pynrrd; the first axis of the file runs fastest."""

import os
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.declared import DEFLATE, data_file, refuse_false_size, unpacked
from craftmesh.io.file_volume import FileVolume
from craftmesh.io.oriented import along_axes

_METHODS = {"gzip": "deflate", "gz": "deflate", "bzip2": "bzip2", "bz2": "bzip2"}
_WIDEST = 8  # bytes of a number


def read(path: str | os.PathLike) -> FileVolume:
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
