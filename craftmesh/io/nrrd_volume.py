"""NRRD volumes (.nrrd, .nhdr), read by pynrrd; the first axis of the file runs fastest."""

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import FileVolume
from craftmesh.io.oriented import along_axes


def read(path: str | os.PathLike) -> FileVolume:
    """Read the labels with `space directions` and `space origin`, or `spacings`, where the header has them.

    The origin of the format is the centre of the first voxel. Raises CraftmeshError, also for oblique axes.
    """
    import nrrd

    try:
        labels, header = nrrd.read(os.fspath(path), index_order="F")
    except Exception as error:  # pynrrd and the decoders that it calls raise many kinds
        reason = " ".join(str(error).split())
        raise CraftmeshError(f"{path}: is not a whole NRRD file ({reason}); export it anew") from None
    steps, has_spacing = _steps(header, labels.ndim)
    first = _numbers(header.get("space origin"), 3)
    turned, spacing, corner = along_axes(path, labels, steps, np.zeros(3) if first is None else first)
    if not has_spacing:
        return FileVolume(turned)
    return FileVolume(turned, spacing, None if first is None else corner)


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
