"""Volumes in HDF5: DREAM.3D (SIMPL layout of versions 6 and 7, older versions, NX) and LabDCT.

Cells are stored as (z, y, x, component), in version 4 flat with x fastest. SIMPL stores the geometry in
`_SIMPL_GEOMETRY` next to the cell data, versions 4 and 5 in the container `VoxelDataContainer` itself. NX
stores it in the attributes of an object of type ImageGeom, above the cell data. LabDCT files are those of
GrainMapper3D: /LabDCT/Data, lengths in mm.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from craftmesh.errors import CraftmeshError, listed
from craftmesh.extras import extra
from craftmesh.io.file_volume import (
    EULERS,
    QUATERNIONS,
    RODRIGUES,
    FileVolume,
    Rotations,
    in_words,
    is_described,
    is_eulers,
    is_phases,
    is_quaternions,
    left_unread,
    of_dream3d,
    of_grains,
    of_space_group,
    pick,
    unit_said,
)
from craftmesh.io.hdf5 import Beside, cells_xyz, datasets, is_by_cell, opened, volume_paths
from craftmesh.types import UNINDEXED, Crystal

with extra("formats"):
    import h5py

_IDS = ("FeatureIds", "GrainIds", "FeatureID", "GrainID")
_PHASE_NAMES = ("PhaseName", "MaterialName")
_DATA = "/LabDCT/Data"
_BEFORE_6 = "VoxelDataContainer"  # group of versions 4 and 5


@dataclass(frozen=True)
class _Image:
    """An image geometry: its HDF5 group, and dims, spacing, origin (3,) along x, y, z."""

    group: h5py.Group
    dims: np.ndarray
    spacing: np.ndarray
    origin: np.ndarray


def read_dream3d(path: str | os.PathLike, dataset: str, table: str = "") -> FileVolume:
    """Read FeatureIds (or the path `dataset`), the geometry, orientations, phases and crystals.

    Bunge's Euler angles and phases come from the table that belongs to the ids (or from `table`, an array
    or its group), else from the cells. Row 0 of a table is a dummy of zeros. Raises CraftmeshError for
    files that are not HDF5, without image geometry, with several volumes of ids, or with no fitting table.
    """
    with opened(path) as file:
        images = _images(file)
        if not images:
            raise CraftmeshError(f"{path}: has no image geometry; export a DREAM.3D volume of voxels")
        ids_by_name = (dataset, *_IDS)
        by_path = {
            name: image for image in images for name in volume_paths(image.group, image.dims, ids_by_name)
        }
        usual = [tuple(p for p in by_path if p.rsplit("/", 1)[1] == name) for name in _IDS]
        wanted = next(filter(None, usual), _IDS)
        if not dataset and len(wanted) > 1 and wanted is not _IDS:
            raise CraftmeshError(f"{path}: has several volumes; set dataset to one of: {listed(wanted)}")
        name = pick(path, dataset, list(by_path), wanted)
        image = by_path[name]
        ids = cells_xyz(file[name], image.dims)
        beside = Beside(path, file[name], ids, image.dims, _arrays(file, images, image), table)
        rotations, phases = _rotations(beside), beside.find(is_phases, 1)
        numbers = phases[1] if phases else None
        crystals, others = _crystals(image, numbers)
        found = [pair[0] for pair in (rotations, phases) if pair]
        notes = left_unread([*beside.unread(found, by_path), *others])
        orientations = {beside.dataset_description(rotations[0]): rotations[1]} if rotations else {}
        place = image.spacing, image.origin
        return FileVolume(ids, *place, orientations, numbers, crystals, UNINDEXED, notes=notes, name=name)


def _rotations(beside: Beside) -> tuple[h5py.Dataset, Rotations] | None:
    """Return the array of Euler angles, else of quaternions (stored x, y, z, w), with its Rotations.

    Returns None if the file has neither. DREAM.3D's quaternions rotate sample to crystal axes, up to
    version 5 crystal to sample axes. Source: DREAM.3D's functions `eu2qu` in OrientationTransforms and,
    earlier, EulertoQuat in OrientationMath.
    """
    if eulers := beside.find(is_eulers, 3):
        data, angles = eulers[0], eulers[1].astype(float)
        if angles.ndim == 2 and not angles[:1].any():
            angles[:1] = np.nan
        words = [data.name, *(f"{key} {value}" for key, value in data.attrs.items())]
        return data, Rotations(EULERS, angles, unit_said(*words))
    if quaternions := beside.find(is_quaternions, 4):
        data, is_inverse = quaternions[0], f"/{_BEFORE_6}/" not in quaternions[0].name
        return data, Rotations(QUATERNIONS, quaternions[1][..., [3, 0, 1, 2]], inverse=is_inverse)
    return None


def _arrays(file: h5py.File, images: Sequence[_Image], image: _Image) -> list[h5py.Dataset]:
    """Return the arrays that may describe the ids of `image`.

    They are below its group, or below no image's group and at most two levels deeper than its group.
    """
    own = image.group.name
    others = tuple(f"{other.group.name}/" for other in images if other.group.name != own)
    found = {name: d for name, d in datasets(file).items() if d.shape and not name.startswith(others)}
    deepest = own.count("/") + 2
    return [d for name, d in found.items() if name.startswith(f"{own}/") or name.count("/") <= deepest]


def _images(file: h5py.File) -> list[_Image]:
    """Return the image geometries of a file, of any layout, in the file's order."""
    found = []

    def visit(name: str, item: h5py.Group | h5py.Dataset) -> None:
        if not isinstance(item, h5py.Group):
            return
        if "DIMENSIONS" in item and "SPACING" in item:
            dims, spacing = (item[key][()] for key in ("DIMENSIONS", "SPACING"))
            origin = item["ORIGIN"][()] if "ORIGIN" in item else np.zeros(3)
            within = item.parent if name.endswith("_SIMPL_GEOMETRY") else item
            found.append(_image(within, dims, spacing, origin))
        elif in_words(item.attrs.get("ObjectType", "")) == "ImageGeom" and "_DIMENSIONS" in item.attrs:
            values = [item.attrs[key] for key in ("_DIMENSIONS", "_SPACING", "_ORIGIN")]
            found.append(_image(item, *values))

    file.visititems(visit)
    return found


def _image(group: h5py.Group, dims: ArrayLike, spacing: ArrayLike, origin: ArrayLike) -> _Image:
    return _Image(group, np.asarray(dims, np.int64), _decimal(spacing), _decimal(origin))


def _decimal(values: ArrayLike) -> np.ndarray:
    """Return float32 values as the nearest short decimals: 0.35 instead of 0.3499999940395355."""
    return np.array([float(str(v)) for v in np.asarray(values).ravel()])


def _crystals(image: _Image, phases: np.ndarray | None) -> tuple[dict[int, Crystal], list[str]]:
    """Return the crystals by phase from the table of phases ("ensembles"), and names of tables not read.

    phases: those of the grains. The table is searched in the geometry's group, then in its parent, and must
    be the only one with a row for each phase; otherwise there are no crystals. Row 0 is a dummy.
    """
    tables: list[h5py.Dataset] = []
    for around in (image.group, image.group.parent):
        found = [
            group.get("CrystalStructures") for group in around.values() if isinstance(group, h5py.Group)
        ]
        tables = tables or [codes for codes in found if isinstance(codes, h5py.Dataset)]
    largest = 0 if phases is None else phases.max(initial=0)
    fitting = [d for d in tables if d.dtype.kind in "iu" and d.size > largest]
    if len(fitting) != 1:
        return {}, [d.name for d in tables]
    group = fitting[0].parent
    codes = fitting[0][()].ravel().tolist()
    names = next((list(np.ravel(group[key][()])) for key in _PHASE_NAMES if key in group), [])
    rows = zip(codes, [*map(in_words, names), *[""] * len(codes)])
    crystals = {phase: Crystal(of_dream3d(code), name) for phase, (code, name) in enumerate(rows) if phase}
    return of_grains(crystals, phases), []


def read_labdct(path: str | os.PathLike, dataset: str) -> FileVolume:
    """Read GrainId (or the path `dataset`), Spacing (mm), and Rodrigues vectors and phases of the voxels.

    Id 0 means unindexed; the file has no origin. Raises CraftmeshError for files that are not HDF5, or
    without three-dimensional GrainId and Spacing.
    """
    with opened(path) as file:
        data, ids = file.get(_DATA), file.get(f"{_DATA}/GrainId")
        if not isinstance(ids, h5py.Dataset) or ids.ndim != 3 or "LabDCT/Spacing" not in file:
            raise CraftmeshError(
                f"{path}: has no {_DATA}/GrainId of three axes with LabDCT/Spacing; "
                "export a LabDCT reconstruction"
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
        crystals = _labdct_crystals(file, numbers)
        spacing = file["LabDCT/Spacing"][()]
    notes = ("lengths are in mm", *left_unread(key for key in described if key != name))
    place = spacing, None
    return FileVolume(labels, *place, orientations, numbers, crystals, UNINDEXED, notes=notes, name=name)


def _labdct_crystals(file: h5py.File, phases: np.ndarray | None) -> dict[int, Crystal]:
    """Return the crystals of /PhaseInfo/Phase01, ... by phase.

    If `phases` is None, a single crystal gets the key 0, and several crystals are left out.
    """
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
    """Return the first value (1,) of the array `key` of a group; shape (0,) if there is none."""
    data = group.get(key)
    return np.ravel(data[()])[:1] if isinstance(data, h5py.Dataset) else np.zeros(0)
