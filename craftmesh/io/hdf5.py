"""HDF5 files: opened, searched and read with errors of one line."""

import os
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager

import h5py
import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.declared import DEFLATE, refuse_false_size


@contextmanager
def opened(path: str | os.PathLike) -> Iterator[h5py.File]:
    """Yield the open file; raises CraftmeshError when it is missing, not HDF5, or damaged.

    Refused too are files whose data lie in other files, and sizes that the file cannot hold.
    """
    try:
        with h5py.File(path, "r") as file:
            _refuse_other_files(path, file)
            yield file
    except FileNotFoundError:
        raise CraftmeshError(f"{path}: no such file; check the path") from None
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:  # h5py's, at broken objects
        raise CraftmeshError(
            f"{path}: is not a whole HDF5 file ({error}); copy or export it anew"
        ) from None


def _refuse_other_files(path: str | os.PathLike, file: h5py.File) -> None:
    """Refuse external links, external and virtual data, and data sets larger than the file can hold."""

    def link(name: str, item: h5py.HardLink | h5py.SoftLink | h5py.ExternalLink) -> None:
        if isinstance(item, h5py.ExternalLink):
            raise CraftmeshError(f"{path}: {name} is in {item.filename}; expected all data in one file")

    def data(name: str, item: h5py.Group | h5py.Dataset) -> None:
        if not isinstance(item, h5py.Dataset):
            return
        if item.external or item.is_virtual:
            raise CraftmeshError(f"{path}: {name} lies in other files; expected all data in one file")
        refuse_false_size(path, name, item.shape or (), item.dtype.itemsize, os.path.getsize(path), DEFLATE)
        chunk = item.chunks or ()
        refuse_false_size(
            path, f"a chunk of {name}", chunk, item.dtype.itemsize, os.path.getsize(path), DEFLATE
        )

    file.visititems_links(link)
    file.visititems(data)


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
    ratio = DEFLATE if data.id.get_create_plist().get_nfilters() else 1
    stored = data.id.get_storage_size()
    refuse_false_size(data.file.filename, data.name, data.shape, data.dtype.itemsize, stored, ratio)
    values = data[()].reshape(*(int(n) for n in dims[::-1]), -1)
    if values.shape[3] == 1:
        values = values[..., 0]
    return values.transpose([2, 1, 0, 3][: values.ndim])
