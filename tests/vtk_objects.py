"""VTK's own objects and writers, for files as other programs make them."""

import os

import numpy as np
from vtkmodules import vtkIOXML
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray


def add_arrays(attributes, arrays):
    """Add named arrays (k,) or (k, c) to the point, cell or field data `attributes`."""
    for name, values in arrays.items():
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        attributes.AddArray(array)


def cell_array(connectivity, offsets):
    """Return a vtkCellArray of the cells connectivity[offsets[i] : offsets[i + 1]]."""
    cells = vtkCellArray()
    ids = (np.ascontiguousarray(a, np.int64) for a in (offsets, connectivity))
    cells.SetData(*(numpy_to_vtkIdTypeArray(a, deep=True) for a in ids))
    return cells


def uniform_cells(cells):
    """Return the rows of `cells` (m, k) as a vtkCellArray."""
    m, k = cells.shape
    return cell_array(cells.ravel(), np.arange(0, m * k + 1, k))


def vtk_points(points):
    """Return vtkPoints that hold `points` (n, 3) in float64."""
    result = vtkPoints()
    result.SetDataTypeToDouble()
    result.SetData(numpy_to_vtk(np.ascontiguousarray(points, float), deep=True))
    return result


def write_dataset(path, dataset, kind):
    """Write a VTK object as VTK XML of `kind` by VTK's writer."""
    writer = getattr(vtkIOXML, f"vtkXML{kind}Writer")()
    writer.SetFileName(os.fspath(path))
    writer.SetInputData(dataset)
    assert writer.Write()
