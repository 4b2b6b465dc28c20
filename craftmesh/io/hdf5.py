"""HDF5 files: opened, searched and read with errors of one line."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import h5py
import numpy as np

from craftmesh.errors import CraftmeshError


@contextmanager
def opened(path: str | os.PathLike) -> Iterator[h5py.File]:
    """Yield the open file; raises CraftmeshError when it is missing, not HDF5, or damaged."""
    try:
        with h5py.File(path, "r") as file:
            yield file
    except FileNotFoundError:
        raise CraftmeshError(f"{path}: no such file; check the path") from None
    except OSError as error:
        raise CraftmeshError(
            f"{path}: is not a whole HDF5 file ({error}); copy or export it anew"
        ) from None


def datasets(group: h5py.Group) -> dict[str, h5py.Dataset]:
    """Return every dataset below `group` by its full path, in the file's order."""
    found = {}

    def visit(_: str, item: h5py.Group | h5py.Dataset) -> None:
        if isinstance(item, h5py.Dataset):
            found[item.name] = item

    group.visititems(visit)
    return found


def volume_paths(group: h5py.Group, dims: Sequence[int] | np.ndarray) -> list[str]:
    """Return the paths of integer datasets below `group` whose shape is `dims`[::-1], or that and 1."""
    shape = tuple(int(n) for n in dims[::-1])
    return [
        path
        for path, data in datasets(group).items()
        if data.dtype.kind in "iu" and data.shape in (shape, (*shape, 1))
    ]


def cells_xyz(data: h5py.Dataset) -> np.ndarray:
    """Return a dataset (z, y, x), (z, y, x, 1) or (z, y, x, c) with its axes in the order x, y, z[, c]."""
    values = data[()]
    if values.ndim == 4 and values.shape[3] == 1:
        values = values[..., 0]
    return values.transpose([2, 1, 0, 3][: values.ndim])
