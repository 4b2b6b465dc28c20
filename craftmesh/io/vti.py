"""VTK image data (.vti), and rectilinear grids (.vtr) of even spacing, with grain ids as cell data.

The files are from DAMASK, other tools or craftmesh.
"""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError, listed
from craftmesh.io import vtk_xml
from craftmesh.io.file_volume import (
    EULERS,
    QUATERNIONS,
    UNSAID,
    FileVolume,
    Rotations,
    is_described,
    is_eulers,
    is_phases,
    left_unread,
    pick,
    unit_said,
)
from craftmesh.io.metaimage_nrrd import ALIGNED
from craftmesh.types import GRAIN, UNINDEXED, VOID

_NAMES = ("labels", "material", "FeatureIds", "GrainIds", "grain", "grain_id", "MaterialId")
_ZERO = {"material": GRAIN, "FeatureIds": UNINDEXED}  # array names of DAMASK and DREAM.3D


def read_vti(path: str | os.PathLike, dataset: str) -> FileVolume:
    """Read grain ids from a cell array: `dataset`, or the first of the usual names, or the only array.

    In DAMASK's array `material`, 0 is a grain. Raises CraftmeshError for damaged files, no unique array,
    labels as point data, rotated axes, and a rectilinear grid (.vtr) of uneven spacing.
    """
    image = _image(path)
    direction = image.place["direction"]
    if not np.allclose(direction, np.eye(3).ravel(), atol=1e-9):
        raise CraftmeshError(
            f"{path}: its axes are rotated (Direction {direction.tolist()}); resample it on axes x, y, z"
        )
    at_cells, at_points = (
        [name for name, values in arrays.items() if values.ndim == 1]
        for arrays in (image.at_cells, image.at_points)
    )
    _refuse_at_points(path, dataset, at_cells, at_points)
    name = pick(path, dataset, at_cells, _NAMES)
    shape = tuple(np.maximum(image.place["steps"], 1).tolist())
    labels = image.at_cells[name].reshape(shape, order="F")
    own = image.others
    if name == "labels" and {"spacing", "origin"} <= own.keys():
        quaternions = own.get("orientations")
        orientations = {} if quaternions is None else {"orientations": Rotations(QUATERNIONS, quaternions)}
        place = own["spacing"], own["origin"]
        return FileVolume(labels, *place, orientations, own.get("phases"), zero=VOID, negative_voids=True)
    spacing = image.place["spacing"]
    origin = image.place["origin"] + spacing * image.place["extent"][::2]
    orientations, phases, unread = _described(image, name, shape)
    return FileVolume(
        labels,
        spacing,
        origin,
        orientations,
        phases,
        {},
        _ZERO.get(name, UNSAID),
        notes=left_unread(unread),
        name=name,
    )


def _image(path: str | os.PathLike) -> vtk_xml.Dataset:
    """Return the image of a .vti, or of a .vtr with even spacing; raises CraftmeshError for other files."""
    if Path(path).suffix.lower() != ".vtr":
        return vtk_xml.read_dataset(path, "ImageData")
    grid = vtk_xml.read_dataset(path, "RectilinearGrid")
    planes = [grid.place[axis].astype(float) for axis in "xyz"]
    spacing = np.array([(at[-1] - at[0]) / max(len(at) - 1, 1) for at in planes])
    for axis, at, step in zip("xyz", planes, spacing):
        steps = np.diff(at)
        if not (np.abs(steps - step) <= ALIGNED * abs(step)).all():
            raise CraftmeshError(
                f"{path}: voxel sizes along {axis} range from {steps.min():.6g} to {steps.max():.6g}; "
                "resample the labels (nearest) to a .vti of equal voxels"
            )
    first = np.array([at[0] for at in planes])
    place = {"spacing": spacing, "origin": first - spacing * grid.place["extent"][::2]}
    return replace(grid, place={**grid.place, **place})


def _described(
    image: vtk_xml.Dataset, labels: str, shape: tuple[int, ...]
) -> tuple[dict[str, Rotations], np.ndarray | None, list[str]]:
    """Return Bunge's angles by name, phases of the cells (nx, ny, nz), and names of arrays not read.

    labels: name of the array of grain ids; shape: numbers of cells along x, y, z. Phases are None if the
    file has none.
    """
    orientations: dict[str, Rotations] = {}
    phases, unread = None, []
    for arrays in (image.at_cells, image.at_points, image.others):
        for name in filter(is_described, arrays):
            width = arrays[name][:1].size if arrays is image.at_cells else 0
            if is_eulers(name) and width == 3:
                angles = arrays[name].reshape(*shape, 3, order="F")
                orientations[name] = Rotations(EULERS, angles, unit_said(name))
            elif is_phases(name) and width == 1 and phases is None and name != labels:
                phases = arrays[name].reshape(shape, order="F")
            elif name != labels:
                unread.append(name)
    return orientations, phases, unread


def _refuse_at_points(
    path: str | os.PathLike, dataset: str, at_cells: list[str], at_points: list[str]
) -> None:
    """Raise CraftmeshError if the labels are point data, and no cell array has their name.

    dataset: the user's name, "" for the usual ones; at_cells, at_points: names of scalar arrays.
    """
    wanted = [dataset] if dataset else _NAMES
    if any(name in at_cells for name in wanted):
        return
    found = [name for name in wanted if name in at_points]
    if found or (at_points and not at_cells and not dataset):
        raise CraftmeshError(
            f"{path}: {listed(found or at_points)} is point data, but labels must be cell data; convert it "
            "by pyvista's ImageData.points_to_cells() (each point a voxel), or ParaView's Point Data "
            "to Cell Data with Categorical Data ticked"
        )
