"""Arrays of an HDF5 file beside its grain ids: the table of the grains, else the cells', and the others."""

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import h5py
import numpy as np

from craftmesh.errors import CraftmeshError, listed
from craftmesh.io.hdf5 import cells_xyz, is_by_cell
from craftmesh.io.side_arrays import belonging, is_described, is_ids

# What is taken of several in one group, the first first.
_USUAL = ("AvgEulerAngles", "EulerAngles", "AvgQuats", "Quats", "Phases")
_ENSEMBLES = "CrystalStructures"  # an array of groups that have a row a phase, not a row a grain


@dataclass(frozen=True)
class Beside:
    """The arrays of a file that may describe the grains of `ids` (nx, ny, nz).

    labels: the dataset of the ids, over cells `dims` (x, y, z); table: the array, or the group of arrays,
    that the user names, "" for what fits.
    """

    path: str | os.PathLike
    labels: h5py.Dataset
    ids: np.ndarray
    dims: np.ndarray
    arrays: Sequence[h5py.Dataset]
    table: str = ""

    def find(self, is_named: Callable[[str], bool], width: int) -> tuple[h5py.Dataset, np.ndarray] | None:
        """Return the array, `width` numbers a row, that is of the grains, else of the cells; None without.

        Its values are a table (g, width), row = id, or of voxels (nx, ny, nz, width); without the last axis
        for a width of 1. Raises CraftmeshError where several tables are as good, and where the one that the
        user names does not fit.
        """
        if self.table and not self._chosen(self.arrays):
            groups = dict.fromkeys(d.parent.name for d in self.arrays if d.parent != self.labels.parent)
            raise CraftmeshError(
                f"{self.path}: no array below {self.table}; give table as one of: {listed(groups)}"
            )
        named = [d for d in self.arrays if is_named(_last(d)) and d.dtype.kind in "iuf"]
        named = self._chosen(named) or named
        cells = [d for d in named if is_by_cell(d, self.dims, width)]
        shapes = ((width,), ()) if width == 1 else ((width,),)
        tables = [d for d in named if d not in cells and d.ndim and d.shape[1:] in shapes]
        rows = {d.name: len(d) for d in _one_a_group(self._linked(tables))}
        near = {name: count for name, count in rows.items() if name.startswith(self._within)}
        name = next(
            (n for r in (near, rows) if (n := belonging(self.path, r, self._largest, self._claimed()))), ""
        )
        found = next((d for d in tables if d.name == name), None)
        if found is not None:
            return found, found[()].reshape(len(found), -1)[:, slice(None) if width > 1 else 0]
        if self._chosen(tables):
            raise CraftmeshError(
                f"{self.path}: ids reach {self._largest}, and the table given has {listed(rows.values())} "
                f"rows ({listed(rows)}); expected a row for each id and for 0"
            )
        cells = _one_a_group(sorted(cells, key=lambda d: d.parent != self.labels.parent))
        return (cells[0], cells_xyz(cells[0], self.dims)) if cells else None

    def unread(self, found: Iterable[h5py.Dataset], volumes: Iterable[str]) -> list[str]:
        """Return what else describes grains, and the other volumes of ids, by their names."""
        used = {self.labels.name, *(d.name for d in found)}
        arrays = [d for d in self.arrays if is_described(_last(d)) and _ENSEMBLES not in d.parent]
        others = {d.name: self.told(d) for d in arrays}
        others |= {name: name for name in volumes if is_ids(name.rsplit("/", 1)[1]) and name not in others}
        return [told for name, told in others.items() if name not in used]

    def told(self, data: h5py.Dataset) -> str:
        """Return an array's name within the file, with its rows where it is a table."""
        rows = "" if np.prod(data.shape) >= self.ids.size else f" ({len(data)} rows)"
        return data.name.removeprefix(self._within) + rows

    def _chosen(self, arrays: Sequence[h5py.Dataset]) -> list[h5py.Dataset]:
        return [d for d in arrays if self.table and f"{d.name}/".startswith(f"{self.table.rstrip('/')}/")]

    def _linked(self, tables: Sequence[h5py.Dataset]) -> list[h5py.Dataset]:
        """Return the tables that may be the ids': a group that holds an array of their name lists them.

        If it lists them one by one they are its rows; else they are the parents of its rows.
        """
        lists = {d.name: d.parent.get(_last(self.labels)) for d in tables}
        lists = {name: ids for name, ids in lists.items() if ids is not None and ids != self.labels}
        own = [n for n, ids in lists.items() if np.array_equal(np.ravel(ids[()]), np.arange(len(ids)))]
        rest = [d for d in tables if d.name not in lists]
        parents = {_last(d) for d in self._other_ids()}  # a table that lists these is not theirs
        of_children = [d for d in rest if len(d) == self._largest + 1 and parents & {*d.parent}]
        return [d for d in tables if d.name in own] or of_children or rest

    def _claimed(self) -> set[int]:
        """Return the counts of rows that other ids of the cells need."""
        return {int(d[()].max(initial=0)) + 1 for d in self._other_ids()}

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
    """Return one array of each group, the one of a usual name where there are several."""
    groups: dict[str, list[h5py.Dataset]] = {}
    for data in arrays:
        groups.setdefault(data.parent.name, []).append(data)
    ranks = {name: rank for rank, name in enumerate(_USUAL)}
    return [min(group, key=lambda d: ranks.get(_last(d), len(ranks))) for group in groups.values()]
