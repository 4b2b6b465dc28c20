"""LabDCT volumes (.h5) as GrainMapper3D writes them: /LabDCT/Data, axes z, y, x, lengths in mm."""

import os

import h5py
import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.crystals import in_words, of_grains, of_space_group
from craftmesh.io.file_volume import RODRIGUES, UNINDEXED, FileVolume, pick, table_rows
from craftmesh.io.hdf5 import cells_xyz, opened, volume_paths
from craftmesh.types import Crystal

_DATA = "/LabDCT/Data"


def read(path: str | os.PathLike, dataset: str) -> FileVolume:
    """Read GrainId (or the path `dataset`), Spacing (mm), and one Rodrigues vector and phase per grain.

    Id 0 is unindexed; the origin is taken as 0. Raises CraftmeshError.
    """
    with opened(path) as file:
        data = file.get(_DATA)
        if data is None or "LabDCT/Spacing" not in file:
            raise CraftmeshError(
                f"{path}: no {_DATA} with LabDCT/Spacing; expected a LabDCT reconstruction"
            )
        ids = data.get("GrainId")
        present = volume_paths(data, ids.shape[::-1]) if ids is not None else []
        name = pick(path, dataset, present, (f"{_DATA}/GrainId",))
        labels = cells_xyz(file[name], ids.shape[::-1])
        vectors = phases = None
        if labels.min(initial=0) >= 0:
            rows = table_rows(path, labels)
            vectors = _vectors(data, labels)
            phases = _phases(data, labels, rows)
        crystals = _crystals(file, phases)
        spacing = file["LabDCT/Spacing"][()]
    orientations = {} if vectors is None else {RODRIGUES: vectors}
    return FileVolume(
        labels, spacing, None, orientations, phases, crystals, UNINDEXED, notes=("lengths are in mm",)
    )


def _crystals(file: h5py.File, phases: np.ndarray | None) -> dict[int, Crystal]:
    """Return the crystals of /PhaseInfo/Phase01 and on; of the only one where grains have no phases."""
    found = {}
    for key, group in file.get("PhaseInfo", {}).items():
        number = key.removeprefix("Phase")
        if number.isdigit() and "SpaceGroup" in group:
            name = in_words(np.ravel(group["Name"][()])[0]) if "Name" in group else ""
            found[int(number)] = Crystal(of_space_group(int(np.ravel(group["SpaceGroup"][()])[0])), name)
    return of_grains(found, phases)


def _vectors(data: h5py.Group, labels: np.ndarray) -> np.ndarray | None:
    """Return the Rodrigues vectors (nx, ny, nz, 3) of the voxels, NaN where unindexed."""
    if "Rodrigues" not in data or data["Rodrigues"].shape != (*labels.shape[::-1], 3):
        return None
    vectors = cells_xyz(data["Rodrigues"], labels.shape).astype(float)
    vectors[labels == 0] = np.nan
    return vectors


def _phases(data: h5py.Group, labels: np.ndarray, rows: int) -> np.ndarray | None:
    """Return the phase of each grain, the highest of its voxels'; the format gives one phase a grain."""
    if "PhaseId" not in data or data["PhaseId"].shape != labels.shape[::-1]:
        return None
    phases = np.zeros(rows, np.int32)
    np.maximum.at(phases, labels.ravel(), cells_xyz(data["PhaseId"], labels.shape).ravel().astype(np.int32))
    phases[0] = 0
    return phases
