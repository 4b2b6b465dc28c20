"""HDF5 files: opened, searched and read with errors of one line."""

import os
from collections.abc import Collection, Iterator, Sequence
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


def volume_paths(
    group: h5py.Group, dims: Sequence[int] | np.ndarray, ids: Collection[str] = ()
) -> list[str]:
    """Return the paths of integer datasets below `group` with one number a cell of `dims` (x, y, z).

    ids: paths and names of datasets that hold ids whatever their type of number.
    """
    return [
        path
        for path, data in datasets(group).items()
        if (data.dtype.kind in "iu" or (data.dtype.kind == "f" and {path, path.rsplit("/", 1)[1]} & {*ids}))
        and is_by_cell(data, dims, 1)
    ]


def is_by_cell(data: h5py.Dataset, dims: Sequence[int] | np.ndarray, width: int) -> bool:
    """Return whether a dataset has `width` numbers a cell: (z, y, x, width), or flat as (n, width).

    With a width of 1 that axis may be missing.
    """
    shape = tuple(int(n) for n in dims[::-1])
    shapes = [shape, (int(np.prod(dims)),)]
    return data.shape in [(*s, width) for s in shapes] + (shapes if width == 1 else [])


def cells_xyz(data: h5py.Dataset, dims: Sequence[int] | np.ndarray) -> np.ndarray:
    """Return a dataset by cell, flat or not, as (nx, ny, nz) or (nx, ny, nz, c)."""
    values = data[()].reshape(*(int(n) for n in dims[::-1]), -1)
    if values.shape[3] == 1:
        values = values[..., 0]
    return values.transpose([2, 1, 0, 3][: values.ndim])
