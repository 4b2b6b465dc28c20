"""The stages' files in VTK XML, for ParaView too: .vti voxels, .vtp surfaces and cracks, .vtu tetrahedra.

Coordinates are float64 bit for bit, and the same input gives the same bytes.
"""

import os
from collections.abc import Mapping

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml
from craftmesh.types import CRACK, Crack, Surface, TetMesh, Voxels

_NODE_SET, _FACE_SET = "node_set:", "face_set:"
_VTK_TRIANGLES = (5, 22)
VTK_CELL_TYPE = {4: 10, 10: 24}  # VTK_TETRA, VTK_QUADRATIC_TETRA: both number nodes as Abaqus does


def write_surface(path: str | os.PathLike, surface: Surface) -> None:
    """Write a .vtp with cell data `sides` (m, 2) int32, `crack` (m,) uint8 and `kind` (m,) uint8."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    poly = vtkPolyData()
    poly.SetPoints(vtk_xml.vtk_points(surface.points))
    poly.SetPolys(vtk_xml.uniform_cells(surface.facets))
    crack = (surface.kind == CRACK).astype(np.uint8)
    vtk_xml.add_arrays(poly.GetCellData(), {"sides": surface.sides, "crack": crack, "kind": surface.kind})
    vtk_xml.write_dataset(path, poly, "PolyData")


def read_surface(path: str | os.PathLike) -> Surface:
    """Read a .vtp of triangles with cell data `sides`, and `kind` or `crack`.

    A file without `kind` gets it from `crack` and from the bounding box: a facet open to one side
    whose corners lie exactly on one of the box's planes belongs to that plane. Raises CraftmeshError
    for a missing file or array, and for cells that are not triangles.
    """
    poly = vtk_xml.read_dataset(path, "PolyData")
    facets, rows = _triangles(path, poly)
    sides = vtk_xml.named_array(path, poly.at_cells, ["sides"], "cell data")[rows]
    kind = vtk_xml.named_array(path, poly.at_cells, ["kind", "crack"], "cell data")[rows]
    if "kind" not in poly.at_cells:
        return Surface.of_facets(poly.points, facets, sides, kind != 0)
    return Surface(poly.points, facets, sides, kind)


def write_crack(path: str | os.PathLike, crack: Crack) -> None:
    """Write a .vtp with the crack's triangles as polygons and its fronts as lines."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    poly = vtkPolyData()
    poly.SetPoints(vtk_xml.vtk_points(crack.points))
    poly.SetPolys(vtk_xml.uniform_cells(crack.triangles))
    if crack.fronts:
        offsets = np.cumsum([0, *(len(front) for front in crack.fronts)])
        poly.SetLines(vtk_xml.cell_array(np.concatenate(crack.fronts), offsets))
    vtk_xml.write_dataset(path, poly, "PolyData")


def read_crack(path: str | os.PathLike) -> Crack:
    """Read a .vtp of triangles as a crack; its lines are the fronts, its arrays are left unread.

    Raises CraftmeshError for a missing or cut file, other polygons and surfaces (cell data `sides`).
    """
    poly = vtk_xml.read_dataset(path, "PolyData")
    if "sides" in poly.at_cells:
        raise CraftmeshError(
            f"{path}: has cell data 'sides': a surface of grains; expected the triangles of a crack"
        )
    triangles, _ = _triangles(path, poly)
    if not len(triangles):
        raise CraftmeshError(f"{path}: holds no triangles, or was cut short; expected those of a crack")
    ids, offsets = poly.cells["Lines"]
    fronts = tuple(np.split(ids, offsets[1:-1])) if len(ids) else ()
    return Crack(poly.points, triangles, fronts)


def write_voxels(path: str | os.PathLike, voxels: Voxels) -> None:
    """Write a .vti with cell data `labels` int32; orientations and phases go into the field data."""
    from vtkmodules.vtkCommonDataModel import vtkImageData

    image = vtkImageData()
    image.SetDimensions(*(n + 1 for n in voxels.labels.shape))
    image.SetSpacing(*voxels.spacing.tolist())
    image.SetOrigin(*voxels.origin.tolist())
    vtk_xml.add_arrays(image.GetCellData(), {"labels": voxels.labels.ravel(order="F")})
    exact = {"spacing": voxels.spacing, "origin": voxels.origin}  # the file's own attributes may be rounded
    optional = {"orientations": voxels.orientations, "phases": voxels.phases}
    known = {name: values for name, values in optional.items() if values is not None}
    vtk_xml.add_arrays(image.GetFieldData(), exact | known)
    vtk_xml.write_dataset(path, image, "ImageData")


def read_voxels(path: str | os.PathLike) -> Voxels:
    """Read a .vti written by `write_voxels`; raises CraftmeshError for a missing file or `labels`."""
    image = vtk_xml.read_dataset(path, "ImageData")
    labels = vtk_xml.named_array(path, image.at_cells, ["labels"], "cell data")
    spacing, origin = (image.others.get(name, image.place[name]) for name in ("spacing", "origin"))
    orientations, phases = (image.others.get(name) for name in ("orientations", "phases"))
    return Voxels(labels.reshape(image.place["steps"], order="F"), spacing, origin, orientations, phases)


def write_tets(path: str | os.PathLike, mesh: TetMesh) -> None:
    """Write a .vtu with cell data `grain` int32; the sets go into the field data, one array a set."""
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

    grid = vtkUnstructuredGrid()
    grid.SetPoints(vtk_xml.vtk_points(mesh.points))
    grid.SetCells(VTK_CELL_TYPE[mesh.tets.shape[1]], vtk_xml.uniform_cells(mesh.tets))
    vtk_xml.add_arrays(grid.GetCellData(), {"grain": mesh.grain})
    vtk_xml.add_arrays(grid.GetFieldData(), set_arrays(mesh))
    vtk_xml.write_dataset(path, grid, "UnstructuredGrid")


def set_arrays(mesh: TetMesh) -> dict[str, np.ndarray]:
    """Return the sets by their names in the field data of a .vtu."""
    sets = {_NODE_SET + name: ids for name, ids in mesh.node_sets.items()}
    return sets | {_FACE_SET + name: rows for name, rows in mesh.face_sets.items()}


def read_tets(path: str | os.PathLike) -> TetMesh:
    """Read a .vtu of 4- or 10-node tetrahedra, which triangles may follow, as those of face sets.

    Raises CraftmeshError for other cells or missing `grain`.
    """
    grid = vtk_xml.read_dataset(path, "UnstructuredGrid")
    connectivity, offsets = grid.cells["Cells"]
    types = grid.types
    count = len(types) - int(np.isin(types, _VTK_TRIANGLES).sum())
    solid = types[:count]
    width = next((w for w, t in VTK_CELL_TYPE.items() if count and (solid == t).all()), None)
    if width is None:
        raise CraftmeshError(
            f"{path}: cell types {np.unique(types).tolist()}; expected only 10 or only 24 (tets)"
        )
    grain = vtk_xml.named_array(path, grid.at_cells, ["grain"], "cell data")[:count]
    node_sets, face_sets = (
        {name[len(prefix) :]: ids for name, ids in grid.others.items() if name.startswith(prefix)}
        for prefix in (_NODE_SET, _FACE_SET)
    )
    tets = connectivity[: offsets[count]].reshape(-1, width)
    return TetMesh(grid.points, tets, grain, node_sets, face_sets)


def _triangles(path: str | os.PathLike, poly: vtk_xml.Dataset) -> tuple[np.ndarray, slice]:
    """Return the triangles (m, 3) of a poly data and their rows in its cell data."""
    connectivity, offsets = poly.cells["Polys"]
    verts, lines, strips = (len(poly.cells[name][1]) - 1 for name in ("Verts", "Lines", "Strips"))
    if (np.diff(offsets) != 3).any() or strips:
        raise CraftmeshError(
            f"{path}: holds polygons that are not triangles; triangulate the surface first"
        )
    return connectivity.reshape(-1, 3), slice(verts + lines, verts + lines + len(offsets) - 1)


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
