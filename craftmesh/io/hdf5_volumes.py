"""Volumes in HDF5: DREAM.3D in the SIMPL layout (versions 6, 7), older ones and that of NX; LabDCT.

Cells are stored (z, y, x, component), in version 4 flat, x fastest. SIMPL keeps its geometry in
`_SIMPL_GEOMETRY` beside the cell data, versions 4 and 5 in the container itself (`VoxelDataContainer`); NX
keeps it in the attributes of an object of type ImageGeom, above the cell data. LabDCT is as GrainMapper3D
writes it: /LabDCT/Data, lengths in mm.
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
    """An image geometry: its group, and dims, spacing, origin in x, y, z."""

    group: h5py.Group
    dims: np.ndarray
    spacing: np.ndarray
    origin: np.ndarray


def read_dream3d(path: str | os.PathLike, dataset: str, table: str = "") -> FileVolume:
    """Read FeatureIds (or the path `dataset`), the geometry, orientations, phases and crystals.

    Euler angles and phases are those of the table that belongs to the ids (or of `table`, an array or its
    group), else those of the cells. Angles are Bunge's. Feature 0 is the format's dummy: a row
    of zeros. Raises CraftmeshError.
    """
    with opened(path) as file:
        images = _images(file)
        if not images:
            raise CraftmeshError(f"{path}: has no image geometry; expected a DREAM.3D volume of voxels")
        ids_by_name = (dataset, *_IDS)
        by_path = {
            name: image for image in images for name in volume_paths(image.group, image.dims, ids_by_name)
        }
        usual = [tuple(p for p in by_path if p.rsplit("/", 1)[1] == name) for name in _IDS]
        wanted = next(filter(None, usual), _IDS)
        if not dataset and len(wanted) > 1 and wanted is not _IDS:
            raise CraftmeshError(f"{path}: holds several volumes; give dataset as one of: {listed(wanted)}")
        name = pick(path, dataset, list(by_path), wanted)
        image = by_path[name]
        ids = cells_xyz(file[name], image.dims)
        beside = Beside(path, file[name], ids, image.dims, _arrays(file, images, image), table)
        rotations, phases = _rotations(beside), beside.find(is_phases, 1)
        numbers = phases[1] if phases else None
        crystals, others = _crystals(image, numbers)
        found = [pair[0] for pair in (rotations, phases) if pair]
        notes = left_unread([*beside.unread(found, by_path), *others])
        orientations = {beside.told(rotations[0]): rotations[1]} if rotations else {}
        place = image.spacing, image.origin
        return FileVolume(ids, *place, orientations, numbers, crystals, UNINDEXED, notes=notes, name=name)


def _rotations(beside: Beside) -> tuple[h5py.Dataset, Rotations] | None:
    """Return the array of the grains' angles, else of their quaternions (x, y, z, w).

    Those are of the rotation from sample to crystal axes, up to version 5 of its inverse. Source: `eu2qu`
    in DREAM.3D's OrientationTransforms and EulertoQuat in its OrientationMath before.
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
    """Return the arrays that may describe an image's ids: those below it, and below none as deep."""
    own = image.group.name
    others = tuple(f"{other.group.name}/" for other in images if other.group.name != own)
    found = {name: d for name, d in datasets(file).items() if d.shape and not name.startswith(others)}
    deepest = own.count("/") + 2
    return [d for name, d in found.items() if name.startswith(f"{own}/") or name.count("/") <= deepest]


def _images(file: h5py.File) -> list[_Image]:
    """Return the image geometries of every layout, in the file's order."""
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
    """Return float32 values as the doubles that were meant: 0.35, not 0.3499999940395355."""
    return np.array([float(str(v)) for v in np.asarray(values).ravel()])


def _crystals(image: _Image, phases: np.ndarray | None) -> tuple[dict[int, Crystal], list[str]]:
    """Return the crystals of the ensembles, row = phase, row 0 a dummy, and the names of tables unread.

    The ensembles are the only ones of the geometry, else of the group around it, with a row for each phase.
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
        crystals = _labdct_crystals(file, numbers)
        spacing = file["LabDCT/Spacing"][()]
    notes = ("lengths are in mm", *left_unread(key for key in described if key != name))
    place = spacing, None
    return FileVolume(labels, *place, orientations, numbers, crystals, UNINDEXED, notes=notes, name=name)


def _labdct_crystals(file: h5py.File, phases: np.ndarray | None) -> dict[int, Crystal]:
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
