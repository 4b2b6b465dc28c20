"""The stages' files in VTK XML: .vti voxels, .vtp surfaces and cracks, .vtu tetrahedra.

ParaView opens them too. Coordinates are float64 without rounding. The same input gives the same bytes.
"""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.npz import read_labels
from craftmesh.io.vtk_xml import Arrays, Dataset, in_rows, named_array, read_dataset, write_dataset
from craftmesh.types import CRACK, Crack, Surface, TetMesh, Voxels

_NODE_SET, _FACE_SET, _ELEMENT_SET = "node_set:", "face_set:", "element_set:"
_VTK_TRIANGLES = (5, 22)
VTK_CELL_TYPE = {4: 10, 10: 24}  # VTK_TETRA, VTK_QUADRATIC_TETRA; their node order is that of Abaqus


def write_surface(path: str | os.PathLike, surface: Surface) -> None:
    """Write a .vtp with cell data `sides` (m, 2) int32, `crack` (m,) uint8 and `kind` (m,) uint8."""
    marks = {"sides": surface.sides, "crack": surface.kind == CRACK, "kind": surface.kind}
    write_facets(path, surface.points, surface.facets, marks)


def write_facets(
    path: str | os.PathLike, points: np.ndarray, facets: np.ndarray, marks: Mapping[str, np.ndarray]
) -> None:
    """Write facets (m, 3) on points (n, 3) as .vtp; marks: cell data by name, booleans become 0 and 1."""
    numbers = {name: mark.astype("u1") if mark.dtype == bool else mark for name, mark in marks.items()}
    data = Dataset(at_cells=numbers, points=points, cells={"Polys": in_rows(facets)})
    write_dataset(path, "PolyData", data)


def read_surface(path: str | os.PathLike) -> Surface:
    """Return the surface in a .vtp of triangles with cell data `sides`, and `kind` or `crack`.

    Without `kind`, it follows from `crack` and the bounding box: a facet with material on one side only,
    whose corners lie exactly on a plane of the box, belongs to this plane. Raises CraftmeshError for a
    missing file or array, and for cells that are not triangles.
    """
    poly = read_dataset(path, "PolyData")
    facets, rows = _triangles(path, poly)
    sides = named_array(path, poly.at_cells, ["sides"], "cell data")[rows]
    kind = named_array(path, poly.at_cells, ["kind", "crack"], "cell data")[rows]
    if "kind" not in poly.at_cells:
        return Surface.of_facets(poly.points, facets, sides, kind != 0)
    return Surface(poly.points, facets, sides, kind)


def write_crack(path: str | os.PathLike, crack: Crack) -> None:
    """Write a .vtp with a crack's triangles as polygons and its fronts as lines."""
    offsets = np.cumsum([0, *(len(front) for front in crack.fronts)])
    lines = np.concatenate([np.zeros(0, np.int64), *crack.fronts]), offsets
    cells = {"Lines": lines, "Polys": in_rows(crack.triangles)}
    write_dataset(path, "PolyData", Dataset(points=crack.points, cells=cells))


def read_crack(path: str | os.PathLike) -> Crack:
    """Return the crack in a .vtp of triangles; its lines are the fronts, its arrays are ignored.

    Raises CraftmeshError for a missing or truncated file, other polygons, and surfaces (cell data `sides`).
    """
    poly = read_dataset(path, "PolyData")
    if "sides" in poly.at_cells:
        raise CraftmeshError(
            f"{path}: is a surface of grains (cell data 'sides'); give the triangles of a crack"
        )
    triangles, _ = _triangles(path, poly)
    if not len(triangles):
        raise CraftmeshError(f"{path}: has no triangles, or is truncated; give the triangles of a crack")
    ids, offsets = poly.cells["Lines"]
    fronts = tuple(np.split(ids, offsets[1:-1])) if len(ids) else ()
    return Crack(poly.points, triangles, fronts)


def read_polygons(path: str | os.PathLike) -> Surface | Crack:
    """Return the surface in a .vtp with cell data `sides`, else the crack in it; raises CraftmeshError."""
    is_surface = "sides" in read_dataset(path, "PolyData").at_cells
    return read_surface(path) if is_surface else read_crack(path)


def read_body(path: Path) -> Voxels | Surface:
    """Return the voxels in a labels .npz or a .vti, or the surface in any other file."""
    if existing(path).suffix == ".npz":
        return read_labels(path)
    return read_voxels(path) if path.suffix == ".vti" else read_surface(path)


def write_voxels(path: str | os.PathLike, voxels: Voxels) -> None:
    """Write a .vti with cell data `labels` int32, and orientations and phases of grains as field data.

    Spacing and origin are field data too. Crystals and orientations of voxels are not written.
    """
    place = {"spacing": voxels.spacing, "origin": voxels.origin}
    optional = {"orientations": voxels.orientations, "phases": voxels.phases}
    known = {name: values for name, values in optional.items() if values is not None}
    extent = np.ravel([(0, n) for n in voxels.labels.shape])
    labels = {"labels": voxels.labels.ravel(order="F")}
    data = Dataset(at_cells=labels, others=place | known, place=place | {"extent": extent})
    write_dataset(path, "ImageData", data)


def read_voxels(path: str | os.PathLike) -> Voxels:
    """Return the voxels in a .vti of `write_voxels`; raises CraftmeshError if it or `labels` is missing."""
    image = read_dataset(path, "ImageData")
    labels = named_array(path, image.at_cells, ["labels"], "cell data")
    spacing, origin = (image.others.get(name, image.place[name]) for name in ("spacing", "origin"))
    orientations, phases = (image.others.get(name) for name in ("orientations", "phases"))
    return Voxels(labels.reshape(image.place["steps"], order="F"), spacing, origin, orientations, phases)


def write_tets(path: str | os.PathLike, mesh: TetMesh) -> None:
    """Write a .vtu with cell data `grain` int32, and an array per set.

    Node and face sets are field data, element sets cell data.
    """
    arrays = {"at_cells": {"grain": mesh.grain, **element_masks(mesh)}, "others": set_arrays(mesh)}
    write_dataset(path, "UnstructuredGrid", tets_alone(mesh.points, mesh.tets, **arrays))


def tets_alone(points: np.ndarray, tets: np.ndarray, **arrays: Arrays) -> Dataset:
    """Return an unstructured grid of only tetrahedra (m, 4 or 10) on points (n, 3).

    arrays: further fields of `Dataset`, such as at_cells.
    """
    types = np.full(len(tets), VTK_CELL_TYPE[tets.shape[1]], np.uint8)
    return Dataset(points=points, cells={"Cells": in_rows(tets)}, types=types, **arrays)


def set_arrays(mesh: TetMesh) -> dict[str, np.ndarray]:
    """Return a mesh's node and face sets by their array names in the field data of a .vtu."""
    sets = {_NODE_SET + name: ids for name, ids in mesh.node_sets.items()}
    return sets | {_FACE_SET + name: rows for name, rows in mesh.face_sets.items()}


def element_masks(mesh: TetMesh, cells: int | None = None) -> dict[str, np.ndarray]:
    """Return a mesh's element sets by their array names in the cell data of a .vtu: uint8, 1 on elements.

    cells: number of cells in the file, the elements first; by default there are no other cells.
    """
    sets, every = mesh.element_sets.items(), np.arange(cells or len(mesh.tets))
    return {_ELEMENT_SET + name: np.isin(every, rows).astype("u1") for name, rows in sets}


def read_tets(path: str | os.PathLike) -> TetMesh:
    """Return the mesh in a .vtu of 4- or 10-node tetrahedra; triangles of face sets after them are ignored.

    Raises CraftmeshError for other cells, and if `grain` is missing.
    """
    grid = read_dataset(path, "UnstructuredGrid")
    connectivity, offsets = grid.cells["Cells"]
    types = grid.types
    count = len(types) - int(np.isin(types, _VTK_TRIANGLES).sum())
    solid = types[:count]
    width = next((w for w, t in VTK_CELL_TYPE.items() if count and (solid == t).all()), None)
    if width is None:
        raise CraftmeshError(
            f"{path}: cell types are {np.unique(types).tolist()}; expected only 10 or only 24 (tetrahedra)"
        )
    grain = named_array(path, grid.at_cells, ["grain"], "cell data")[:count]
    node_sets, face_sets = (
        {name[len(prefix) :]: ids for name, ids in grid.others.items() if name.startswith(prefix)}
        for prefix in (_NODE_SET, _FACE_SET)
    )
    element_sets = {
        name[len(_ELEMENT_SET) :]: np.flatnonzero(mask[:count])
        for name, mask in grid.at_cells.items()
        if name.startswith(_ELEMENT_SET)
    }
    tets = connectivity[: offsets[count]].reshape(-1, width)
    return TetMesh(grid.points, tets, grain, node_sets, face_sets, element_sets)


def _triangles(path: str | os.PathLike, poly: Dataset) -> tuple[np.ndarray, slice]:
    """Return the triangles (m, 3) of a PolyData and the slice of their rows in its cell data.

    Raises CraftmeshError if a polygon is not a triangle, or if there are triangle strips.
    """
    connectivity, offsets = poly.cells["Polys"]
    verts, lines, strips = (len(poly.cells[name][1]) - 1 for name in ("Verts", "Lines", "Strips"))
    if (np.diff(offsets) != 3).any() or strips:
        raise CraftmeshError(
            f"{path}: contains polygons that are not triangles; triangulate the surface first"
        )
    return connectivity.reshape(-1, 3), slice(verts + lines, verts + lines + len(offsets) - 1)
