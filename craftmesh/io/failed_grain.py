"""The surface of a grain that could not be meshed, for viewing."""

import os
from collections.abc import Mapping

import numpy as np

from craftmesh.io import vtk_xml


def write_failed_grain(
    path: str | os.PathLike, points: np.ndarray, facets: np.ndarray, marks: Mapping[str, np.ndarray]
) -> None:
    """Write facets (m, 3) on points (n, 3) as .vtp with `marks` (m,) as cell data, bools as 0 and 1."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    poly = vtkPolyData()
    poly.SetPoints(vtk_xml.vtk_points(points))
    poly.SetPolys(vtk_xml.uniform_cells(facets))
    numbers = {name: mark.astype("u1") if mark.dtype == bool else mark for name, mark in marks.items()}
    vtk_xml.add_arrays(poly.GetCellData(), numbers)
    vtk_xml.write_dataset(path, poly, "PolyData")
