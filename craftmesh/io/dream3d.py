"""DREAM.3D volumes: the SIMPL layout (versions 6 and 7), the older ones, and that of DREAM.3D-NX (simplnx).

Cells are stored (z, y, x, component), in version 4 flat, x fastest. SIMPL keeps its geometry in
`_SIMPL_GEOMETRY` beside the cell data, versions 4 and 5 in the container itself (`VoxelDataContainer`); NX
keeps it in the attributes of an object of type ImageGeom, above the cell data.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import h5py
import numpy as np
from numpy.typing import ArrayLike

from craftmesh.errors import CraftmeshError
from craftmesh.io.crystals import in_words, of_dream3d, of_grains
from craftmesh.io.file_volume import EULERS, UNINDEXED, FileVolume, listed, pick
from craftmesh.io.hdf5 import cells_xyz, is_by_cell, opened, volume_paths
from craftmesh.types import Crystal

_IDS = ("FeatureIds", "GrainIds", "FeatureID", "GrainID")
_PHASE_NAMES = ("PhaseName", "MaterialName")
_FEATURE_ANGLES = ("AvgEulerAngles", "EulerAngles", "AvgEulers")


@dataclass(frozen=True)
class _Image:
    """An image geometry: its group, and dims, spacing, origin in x, y, z."""

    group: h5py.Group
    dims: np.ndarray
    spacing: np.ndarray
    origin: np.ndarray


def read(path: str | os.PathLike, dataset: str) -> FileVolume:
    """Read FeatureIds (or the path `dataset`), the geometry, and orientations per feature or per cell.

    Euler angles are Bunge's, in radians. Feature 0 is the format's dummy: its row becomes NaN. Raises
    CraftmeshError.
    """
    with opened(path) as file:
        images = _images(file)
        if not images:
            raise CraftmeshError(f"{path}: has no image geometry; expected a DREAM.3D volume of voxels")
        ids_by_name = (dataset, *_IDS)
        by_path = {
            name: image for image in images for name in volume_paths(image.group, image.dims, ids_by_name)
        }
        name = pick(path, dataset, list(by_path), _preferred(path, by_path))
        image, matrix = by_path[name], file[name].parent
        ids = cells_xyz(file[name], image.dims)
        angles = _angles(image, matrix, ids)
        orientations = {} if angles is None else {EULERS: angles}
        phases = _phases(image, matrix)
        crystals = _crystals(image, phases)
        return FileVolume(ids, image.spacing, image.origin, orientations, phases, crystals, UNINDEXED)


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


def _preferred(path: str | os.PathLike, by_path: Mapping[str, _Image]) -> tuple[str, ...]:
    """Return the paths that end in a usual name of grain ids; refuses a choice between several volumes."""
    for name in _IDS:
        found = tuple(p for p in by_path if p.rsplit("/", 1)[1] == name)
        if len(found) > 1:
            raise CraftmeshError(f"{path}: holds several volumes; give dataset as one of: {listed(found)}")
        if found:
            return found
    return _IDS


def _matrices(image: _Image, cell_matrix: h5py.Group) -> list[h5py.Group]:
    """Return the feature-level groups of the geometry: those beside its cell data."""
    groups = [item for item in image.group.values() if isinstance(item, h5py.Group)]
    return [group for group in groups if group.name != cell_matrix.name]


def _feature_table(
    image: _Image, matrix: h5py.Group, names: Sequence[str], width: int
) -> np.ndarray | None:
    for group in _matrices(image, matrix):
        for name in names:
            data = group.get(name)
            if isinstance(data, h5py.Dataset) and data.shape[1:] in ((width,), () if width == 1 else None):
                return data[()].reshape(-1, width)
    return None


def _angles(image: _Image, matrix: h5py.Group, ids: np.ndarray) -> np.ndarray | None:
    """Return Bunge's angles (g, 3) by feature, else (nx, ny, nz, 3) by cell, NaN for the dummy 0."""
    angles = _feature_table(image, matrix, _FEATURE_ANGLES, 3)
    if angles is not None:
        angles = angles.astype(float)
        angles[:1] = np.nan
        return angles
    cells = matrix.get("EulerAngles")
    if not isinstance(cells, h5py.Dataset) or not is_by_cell(cells, image.dims, 3) or ids.min() < 0:
        return None
    angles = cells_xyz(cells, image.dims).astype(float)
    angles[ids == 0] = np.nan
    return angles


def _phases(image: _Image, matrix: h5py.Group) -> np.ndarray | None:
    phases = _feature_table(image, matrix, ("Phases",), 1)
    return None if phases is None else phases[:, 0]


def _crystals(image: _Image, phases: np.ndarray | None) -> dict[int, Crystal]:
    """Return the crystals of the ensembles, row = phase, row 0 a dummy.

    The ensembles of the geometry, else those of the group around it; of the only phase where grains have
    none.
    """
    for group in (image.group, image.group.parent):
        tables = [g for g in group.values() if isinstance(g, h5py.Group) and "CrystalStructures" in g]
        if len(tables) == 1:
            break
    else:
        return {}
    codes = tables[0]["CrystalStructures"][()].ravel().tolist()
    names = next(
        (tables[0][key][()].ravel() for key in _PHASE_NAMES if key in tables[0]), [""] * len(codes)
    )
    found = {
        k: Crystal(of_dream3d(int(code)), in_words(name))
        for k, (code, name) in enumerate(zip(codes, names))
    }
    found.pop(0, None)
    return of_grains(found, phases)
