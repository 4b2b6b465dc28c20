"""A mesh with its sets for viewing in ParaView and for other programs, as VTK XML (.vtu)."""

import os

import numpy as np

from craftmesh.io import vtk_xml
from craftmesh.io.vtk import VTK_CELL_TYPE, set_arrays
from craftmesh.types import TetMesh

VTK_FACE_TYPE = {4: 5, 10: 22}  # VTK_TRIANGLE, VTK_QUADRATIC_TRIANGLE


def write_vtu(path: str | os.PathLike, mesh: TetMesh) -> None:
    """Write the tetrahedra, then the triangles of each face set, with normals out of their elements.

    Cell data: `grain` int32, 0 on triangles; `face_set` int32, 0 on tetrahedra and k on the triangles of
    the k-th face set. Point data: for each node set an array of its name, uint8, 1 on its nodes. The field
    data are those of `write_tets`, whose reader reads this file too.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

    width, count = mesh.tets.shape[1], len(mesh.tets)
    triangles = [mesh.outward_triangles(name) for name in mesh.face_sets]
    numbers = np.repeat(np.arange(1, len(triangles) + 1), [len(rows) for rows in triangles])
    total = len(numbers)
    sizes = np.repeat([width, 3 if width == 4 else 6], [count, total])
    types = np.repeat([VTK_CELL_TYPE[width], VTK_FACE_TYPE[width]], [count, total]).astype(np.uint8)
    nodes = np.concatenate([mesh.tets.ravel(), *(rows.ravel() for rows in triangles)])
    grid = vtkUnstructuredGrid()
    grid.SetPoints(vtk_xml.vtk_points(mesh.points))
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    grid.SetCells(numpy_to_vtk(types, deep=True), vtk_xml.cell_array(nodes, offsets))
    grain = np.concatenate([mesh.grain, np.zeros(total, np.int32)])
    number = np.concatenate([np.zeros(count, np.int32), numbers.astype(np.int32)])
    vtk_xml.add_arrays(grid.GetCellData(), {"grain": grain, "face_set": number})
    masks = {name: _mask(nodes, len(mesh.points)) for name, nodes in mesh.node_sets.items()}
    vtk_xml.add_arrays(grid.GetPointData(), masks)
    vtk_xml.add_arrays(grid.GetFieldData(), set_arrays(mesh))
    vtk_xml.write_dataset(path, grid, "UnstructuredGrid")


def _mask(chosen: np.ndarray, count: int) -> np.ndarray:
    mask = np.zeros(count, np.uint8)
    mask[chosen] = 1
    return mask
