"""The surface of a grain that could not be meshed, for viewing."""

import os

from craftmesh.io import vtk_xml
from craftmesh.tetrahedra.diagnose import GrainFailure


def write_failed_grain(path: str | os.PathLike, failure: GrainFailure) -> None:
    """Write the grain's surface as .vtp with cell data `at_fault` (1: facets to repair) and `crack`."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    surface = failure.surface
    poly = vtkPolyData()
    poly.SetPoints(vtk_xml.vtk_points(surface.points))
    poly.SetPolys(vtk_xml.uniform_cells(surface.facets))
    marks = {"at_fault": failure.at_fault.astype("u1"), "crack": surface.internal.astype("u1")}
    vtk_xml.add_arrays(poly.GetCellData(), marks | {"facet": surface.facet_ids})
    vtk_xml.write_dataset(path, poly, "PolyData")
