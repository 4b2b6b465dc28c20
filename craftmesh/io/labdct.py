"""LabDCT volumes (.h5) as GrainMapper3D writes them: /LabDCT/Data, axes z, y, x, lengths in mm."""

import os

import h5py
import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.crystals import in_words, of_grains, of_space_group
from craftmesh.io.file_volume import RODRIGUES, FileVolume, Rotations, pick
from craftmesh.io.hdf5 import cells_xyz, is_by_cell, opened, volume_paths
from craftmesh.io.side_arrays import is_described, left_unread
from craftmesh.types import UNINDEXED, Crystal

_DATA = "/LabDCT/Data"


def read(path: str | os.PathLike, dataset: str) -> FileVolume:
    """Read GrainId (or the path `dataset`), Spacing (mm), and one Rodrigues vector and phase per grain.

    Id 0 is unindexed; the origin is taken as 0. Raises CraftmeshError.
    """
    with opened(path) as file:
        data, ids = file.get(_DATA), file.get(f"{_DATA}/GrainId")
        if not isinstance(ids, h5py.Dataset) or ids.ndim != 3 or "LabDCT/Spacing" not in file:
            raise CraftmeshError(
                f"{path}: no {_DATA}/GrainId over three axes with LabDCT/Spacing; "
                "expected a LabDCT reconstruction"
            )
        shape = ids.shape[::-1]
        name = pick(path, dataset, volume_paths(data, shape), (f"{_DATA}/GrainId",))
        labels = cells_xyz(file[name], shape)
        described = {d.name: d for d in data.values() if isinstance(d, h5py.Dataset)}
        described = {key: d for key, d in described.items() if is_described(key.rsplit("/", 1)[1])}
        vectors, phases = (described.get(f"{_DATA}/{key}") for key in ("Rodrigues", "PhaseId"))
        orientations, numbers = {}, None
        if vectors is not None and is_by_cell(vectors, shape, 3):
            orientations = {"Rodrigues": Rotations(RODRIGUES, cells_xyz(vectors, shape))}
            del described[vectors.name]
        if phases is not None and is_by_cell(phases, shape, 1):
            numbers = cells_xyz(phases, shape)
            del described[phases.name]
        crystals = _crystals(file, numbers)
        spacing = file["LabDCT/Spacing"][()]
    notes = ("lengths are in mm", *left_unread(key for key in described if key != name))
    return FileVolume(labels, spacing, None, orientations, numbers, crystals, UNINDEXED, notes=notes)


def _crystals(file: h5py.File, phases: np.ndarray | None) -> dict[int, Crystal]:
    """Return the crystals of /PhaseInfo/Phase01 and on; of the only one where grains have no phases."""
    info = file.get("PhaseInfo")
    found = {}
    for key, group in info.items() if isinstance(info, h5py.Group) else ():
        number = key.removeprefix("Phase")
        if number.isdecimal() and isinstance(group, h5py.Group):
            space_group, names = _first(group, "SpaceGroup"), _first(group, "Name")
            structure = "".join(of_space_group(n) for n in space_group if space_group.dtype.kind in "iuf")
            found[int(number)] = Crystal(structure, "".join(map(in_words, names)))
    return of_grains(found, phases)


def _first(group: h5py.Group, key: str) -> np.ndarray:
    """Return the first value of an array of a group (1,), (0,) where there is none."""
    data = group.get(key)
    return np.ravel(data[()])[:1] if isinstance(data, h5py.Dataset) else np.zeros(0)
