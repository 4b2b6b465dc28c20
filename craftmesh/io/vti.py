"""VTK image data (.vti) with grain ids as cell data: DAMASK's files, other tools', and craftmesh's own."""

import os
from typing import TYPE_CHECKING

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
from craftmesh.types import GRAIN, UNINDEXED, VOID

if TYPE_CHECKING:
    from vtkmodules.vtkCommonDataModel import vtkFieldData, vtkImageData

_NAMES = ("labels", "material", "FeatureIds", "GrainIds", "grain", "grain_id", "MaterialId")
_ZERO = {"material": GRAIN, "FeatureIds": UNINDEXED}  # of DAMASK, of DREAM.3D


def read_vti(path: str | os.PathLike, dataset: str) -> FileVolume:
    """Read an integer cell array: `dataset`, or the first of the usual names, or the only one there is.

    In an array `material`, DAMASK's, 0 is a grain. Raises CraftmeshError, also for axes that are turned.
    """
    image = vtk_xml.read_dataset(path, "ImageData")
    matrix = image.GetDirectionMatrix()
    direction = np.array([[matrix.GetElement(i, j) for j in range(3)] for i in range(3)])
    if not np.allclose(direction, np.eye(3), atol=1e-9):
        raise CraftmeshError(
            f"{path}: its axes are turned (Direction {direction.ravel().tolist()}); "
            "resample it on axes x, y, z"
        )
    at_cells, at_points = (_scalars(data) for data in (image.GetCellData(), image.GetPointData()))
    _refuse_at_points(path, dataset, at_cells, at_points)
    name = pick(path, dataset, at_cells, _NAMES)
    shape = [max(n - 1, 1) for n in image.GetDimensions()]
    labels = vtk_xml.named_array(path, image.GetCellData(), [name], "cell data").reshape(shape, order="F")
    exact = {key: vtk_xml.field_array(image, key) for key in ("spacing", "origin")}
    if name == "labels" and exact["spacing"] is not None and exact["origin"] is not None:
        quaternions, phases = (vtk_xml.field_array(image, key) for key in ("orientations", "phases"))
        orientations = {} if quaternions is None else {"orientations": Rotations(QUATERNIONS, quaternions)}
        place = exact["spacing"], exact["origin"]
        return FileVolume(labels, *place, orientations, phases, zero=VOID, negative_voids=True)
    spacing = np.array(image.GetSpacing())
    origin = np.array(image.GetOrigin()) + spacing * image.GetExtent()[::2]
    orientations, phases, unread = _described(image, name, tuple(shape))
    return FileVolume(
        labels,
        spacing,
        origin,
        orientations,
        phases,
        {},
        _ZERO.get(name, UNSAID),
        notes=left_unread(unread),
    )


def _described(
    image: "vtkImageData", labels: str, shape: tuple[int, ...]
) -> tuple[dict[str, Rotations], np.ndarray | None, list[str]]:
    """Return Bunge's angles and the phases of the cells (nx, ny, nz), and the names of what is unread."""
    orientations: dict[str, Rotations] = {}
    phases, unread = None, []
    for attributes in (image.GetCellData(), image.GetPointData(), image.GetFieldData()):
        for name in filter(
            is_described, map(attributes.GetArrayName, range(attributes.GetNumberOfArrays()))
        ):
            array = attributes.GetArray(name)
            width = array.GetNumberOfComponents() if array and attributes is image.GetCellData() else 0
            if is_eulers(name) and width == 3:
                angles = vtk_xml.as_numpy(array).reshape(*shape, 3, order="F")
                orientations[name] = Rotations(EULERS, angles, unit_said(name))
            elif is_phases(name) and width == 1 and phases is None and name != labels:
                phases = vtk_xml.as_numpy(array).reshape(shape, order="F")
            elif name != labels:
                unread.append(name)
    return orientations, phases, unread


def _refuse_at_points(
    path: str | os.PathLike, dataset: str, at_cells: list[str], at_points: list[str]
) -> None:
    """Refuse labels at points where no cell array has the name asked for, or a usual one."""
    wanted = [dataset] if dataset else _NAMES
    if any(name in at_cells for name in wanted):
        return
    found = [name for name in wanted if name in at_points]
    if found or (at_points and not at_cells and not dataset):
        raise CraftmeshError(
            f"{path}: {listed(found or at_points)} is point data; expected labels as cell data: turn it by "
            "ImageData.points_to_cells() of pyvista (each point a voxel), or ParaView's Point Data "
            "to Cell Data with Categorical Data ticked"
        )


def _scalars(data: "vtkFieldData") -> list[str]:
    """Return the names of the arrays that have one number a cell or point."""
    arrays = [data.GetArray(i) for i in range(data.GetNumberOfArrays())]
    return [a.GetName() for a in arrays if a is not None and a.GetNumberOfComponents() == 1]
