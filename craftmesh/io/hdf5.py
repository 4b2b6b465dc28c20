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
    links: list[str] = []
    data_sets = []

    def note_link(name: str, item: h5py.HardLink | h5py.SoftLink | h5py.ExternalLink) -> None:
        if isinstance(item, h5py.ExternalLink):
            links.append(name)

    def note_data(_: str, item: h5py.Group | h5py.Dataset) -> None:
        if isinstance(item, h5py.Dataset):
            data_sets.append(item)

    file.visititems_links(note_link)
    file.visititems(note_data)
    outside = links + [data.name for data in data_sets if data.external or data.is_virtual]
    if outside:
        raise CraftmeshError(f"{path}: {outside[0]} lies in another file; expected all data in this one")
    there = os.path.getsize(path)
    for data in data_sets:
        for what, shape in ((data.name, data.shape), (f"a chunk of {data.name}", data.chunks)):
            refuse_false_size(path, what, shape or (), data.dtype.itemsize, there, DEFLATE)


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
