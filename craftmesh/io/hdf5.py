"""Reading of HDF5 files with one-line errors: volumes by cell, and tables by grain id."""

import os
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError, existing, listed
from craftmesh.extras import extra
from craftmesh.io.file_volume import belonging, is_described, is_ids
from craftmesh.io.header_checks import DEFLATE, refuse_false_size

with extra("formats"):
    import h5py

# Names of arrays in order of preference, where one group contains several of them.
_USUAL = ("AvgEulerAngles", "EulerAngles", "AvgQuats", "Quats", "Phases")
_ENSEMBLES = "CrystalStructures"  # an array that marks groups with one row per phase, not per grain


@contextmanager
def opened(path: str | os.PathLike) -> Iterator[h5py.File]:
    """Yield the open file; raises CraftmeshError if it is missing, not HDF5, or damaged.

    It also raises if data are stored in other files, or if a dataset declares more than the file can hold.
    """
    existing(Path(path))
    try:
        with h5py.File(path, "r") as file:
            _refuse_other_files(path, file)
            yield file
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:  # h5py, for damaged data
        raise CraftmeshError(
            f"{path}: is not a complete HDF5 file ({error}); copy or export it again"
        ) from None


def _refuse_other_files(path: str | os.PathLike, file: h5py.File) -> None:
    """Raise CraftmeshError for data in other files, and for datasets that declare more than the file holds.

    Data in other files are external links, external datasets and virtual datasets.
    """
    links: list[str] = []

    def note_link(name: str, item: h5py.HardLink | h5py.SoftLink | h5py.ExternalLink) -> None:
        if isinstance(item, h5py.ExternalLink):
            links.append(name)

    file.visititems_links(note_link)
    data_sets = datasets(file).values()
    outside = links + [data.name for data in data_sets if data.external or data.is_virtual]
    if outside:
        raise CraftmeshError(f"{path}: {outside[0]} is stored in another file; export all data to one file")
    there = os.path.getsize(path)
    for data in data_sets:
        for what, shape in ((data.name, data.shape), (f"a chunk of {data.name}", data.chunks)):
            refuse_false_size(path, what, shape or (), data.dtype.itemsize, there, DEFLATE)


def datasets(group: h5py.Group) -> dict[str, h5py.Dataset]:
    """Return all datasets below `group` by full path, in the file's order."""
    found = {}

    def visit(_: str, item: h5py.Group | h5py.Dataset) -> None:
        if isinstance(item, h5py.Dataset):
            found[item.name] = item

    group.visititems(visit)
    return found


def volume_paths(
    group: h5py.Group, dims: Sequence[int] | np.ndarray, ids: Collection[str] = ()
) -> list[str]:
    """Return the paths of integer datasets below `group` with one number per cell.

    dims: numbers of cells along x, y, z; ids: paths or names of datasets that count although they are
    floats.
    """
    return [
        path
        for path, data in datasets(group).items()
        if (data.dtype.kind in "iu" or (data.dtype.kind == "f" and {path, path.rsplit("/", 1)[1]} & {*ids}))
        and is_by_cell(data, dims, 1)
    ]


def is_by_cell(data: h5py.Dataset, dims: Sequence[int] | np.ndarray, width: int) -> bool:
    """Return True if a dataset has `width` numbers per cell: shape (z, y, x, width) or (n, width).

    dims: numbers of cells along x, y, z. If `width` is 1, the last axis may be missing.
    """
    shape = tuple(int(n) for n in dims[::-1])
    shapes = [shape, (int(np.prod(dims)),)]
    return data.shape in [(*s, width) for s in shapes] + (shapes if width == 1 else [])


def cells_xyz(data: h5py.Dataset, dims: Sequence[int] | np.ndarray) -> np.ndarray:
    """Return a dataset with c numbers per cell as (nx, ny, nz), or as (nx, ny, nz, c) for c > 1.

    data: of shape (z, y, x, c), (n, c) or, for c = 1, without the last axis; dims: cells along x, y, z.
    """
    ratio = DEFLATE if data.id.get_create_plist().get_nfilters() else 1
    stored = data.id.get_storage_size()
    refuse_false_size(data.file.filename, data.name, data.shape, data.dtype.itemsize, stored, ratio)
    values = data[()].reshape(*(int(n) for n in dims[::-1]), -1)
    if values.shape[3] == 1:
        values = values[..., 0]
    return values.transpose([2, 1, 0, 3][: values.ndim])


@dataclass(frozen=True)
class Beside:
    """The arrays of a file that may describe the grains of `ids` (nx, ny, nz).

    labels: the dataset of these ids; dims: numbers of cells along x, y, z; arrays: the candidates; table:
    path of the array or group that the user chose, "" for automatic choice.
    """

    path: str | os.PathLike
    labels: h5py.Dataset
    ids: np.ndarray
    dims: np.ndarray
    arrays: Sequence[h5py.Dataset]
    table: str = ""

    def find(self, is_named: Callable[[str], object], width: int) -> tuple[h5py.Dataset, np.ndarray] | None:
        """Return an array with a row per grain, else one with a row per voxel, and its values; else None.

        is_named: test of an array's name; width: numbers per row. Values are a table (g, width) whose row k
        belongs to grain k, or (nx, ny, nz, width) by voxel; without the last axis if width is 1. Raises
        CraftmeshError if several tables have numbers of rows that fit the grain ids equally well
        (`belonging`), or if that of the table chosen by the option `table` does not fit.
        """
        if self.table and not self._chosen(self.arrays):
            groups = dict.fromkeys(d.parent.name for d in self.arrays if d.parent != self.labels.parent)
            raise CraftmeshError(
                f"{self.path}: no array below {self.table}; set table to one of: {listed(groups)}"
            )
        named = [d for d in self.arrays if is_named(_last(d)) and d.dtype.kind in "iuf"]
        named = self._chosen(named) or named
        cells = [d for d in named if is_by_cell(d, self.dims, width)]
        shapes = ((width,), ()) if width == 1 else ((width,),)
        tables = [d for d in named if d not in cells and d.ndim and d.shape[1:] in shapes]
        rows = {d.name: len(d) for d in _one_a_group(self._linked(tables))}
        near = {name: count for name, count in rows.items() if name.startswith(self._within)}
        # numbers of rows that tables of other volumes of ids need
        claimed = {int(d[()].max(initial=0)) + 1 for d in self._other_ids()}
        name = next((n for r in (near, rows) if (n := belonging(self.path, r, self._largest, claimed))), "")
        found = next((d for d in tables if d.name == name), None)
        if found is not None:
            return found, found[()].reshape(len(found), -1)[:, slice(None) if width > 1 else 0]
        if self._chosen(tables):
            raise CraftmeshError(
                f"{self.path}: ids reach {self._largest}, but the table given has {listed(rows.values())} "
                f"rows ({listed(rows)}); set table to one with a row for each id and for 0"
            )
        cells = _one_a_group(sorted(cells, key=lambda d: d.parent != self.labels.parent))
        return (cells[0], cells_xyz(cells[0], self.dims)) if cells else None

    def unread(self, found: Iterable[h5py.Dataset], volumes: Iterable[str]) -> list[str]:
        """Return the names of arrays that describe grains but were not used, and of other id volumes.

        found: the arrays used; volumes: paths of all integer volumes in the file.
        """
        used = {self.labels.name, *(d.name for d in found)}
        arrays = [d for d in self.arrays if is_described(_last(d)) and _ENSEMBLES not in d.parent]
        others = {d.name: self.dataset_description(d) for d in arrays}
        others |= {name: name for name in volumes if is_ids(name.rsplit("/", 1)[1]) and name not in others}
        return [told for name, told in others.items() if name not in used]

    def dataset_description(self, data: h5py.Dataset) -> str:
        """Return an array's path below the parent of the labels' group; a table's with its row count."""
        rows = "" if np.prod(data.shape) >= self.ids.size else f" ({len(data)} rows)"
        return data.name.removeprefix(self._within) + rows

    def _chosen(self, arrays: Sequence[h5py.Dataset]) -> list[h5py.Dataset]:
        return [d for d in arrays if self.table and f"{d.name}/".startswith(f"{self.table.rstrip('/')}/")]

    def _linked(self, tables: Sequence[h5py.Dataset]) -> list[h5py.Dataset]:
        """Return the tables in which row k may describe id k of `labels`, by the arrays in their groups.

        If a table's group also has an array named like `labels`, with the values 0, 1, 2, ..., the table is
        returned. With other values, these ids are parents of the objects that the rows describe, and the
        table is never returned. If no table is returned by this rule, the tables of groups without such an
        array are candidates. Preferred among them are tables with a row per id whose group has an array
        named like another volume of ids; if there are none, all candidates are returned.
        """
        lists = {d.name: d.parent.get(_last(self.labels)) for d in tables}
        lists = {name: ids for name, ids in lists.items() if ids is not None and ids != self.labels}
        own = [n for n, ids in lists.items() if np.array_equal(np.ravel(ids[()]), np.arange(len(ids)))]
        rest = [d for d in tables if d.name not in lists]
        parents = {_last(d) for d in self._other_ids()}  # a group with parents' ids describes children
        of_children = [d for d in rest if len(d) == self._largest + 1 and parents & {*d.parent}]
        return [d for d in tables if d.name in own] or of_children or rest

    def _other_ids(self) -> list[h5py.Dataset]:
        ids = [d for d in self.arrays if is_ids(_last(d)) and d.dtype.kind in "iu" and d != self.labels]
        return [d for d in ids if is_by_cell(d, self.dims, 1)]

    @property
    def _within(self) -> str:
        return f"{self.labels.parent.parent.name}/"

    @property
    def _largest(self) -> int:
        largest = self.ids.max(initial=0)
        return int(largest) if np.isfinite(largest) else 0


def _last(data: h5py.Dataset) -> str:
    return data.name.rsplit("/", 1)[1]


def _one_a_group(arrays: Iterable[h5py.Dataset]) -> list[h5py.Dataset]:
    """Return one array of each group: the first by the order of names in _USUAL; other names come last."""
    groups: dict[str, list[h5py.Dataset]] = {}
    for data in arrays:
        groups.setdefault(data.parent.name, []).append(data)
    ranks = {name: rank for rank, name in enumerate(_USUAL)}
    return [min(group, key=lambda d: ranks.get(_last(d), len(ranks))) for group in groups.values()]
