"""Conversion of meshio's meshes to tetrahedra, and back with their crack opened."""

from typing import TYPE_CHECKING

import numpy as np

from craftmesh.errors import CraftmeshError, listed
from craftmesh.extras import extra
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.mesh.tet_connectivity import (
    RowGroups,
    group_edges,
    group_triples,
    half_face_corners,
    tet_edges,
    tet_volumes,
)
from craftmesh.types import TetMesh

if TYPE_CHECKING:
    from meshio import Mesh

TETRAHEDRA = {"tetra": 4, "tetra10": 10}
FACES = {"triangle": 3, "triangle6": 6}
EDGES = {"line": 2, "line3": 3}
# Node order that swaps corners 1 and 2, with the mid nodes of their edges, which makes the volume of an
# inverted element positive.
_MIRRORED = {4: [1, 0, 2, 3], 10: [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]}
# Cell data of Gmsh's group and entity numbers: new cells get new numbers.
_TAGS = ("gmsh:physical", "gmsh:geometrical")


def tet_mesh_of(mesh: "Mesh") -> TetMesh:
    """Return the tetrahedra of all blocks, in order, and the point sets; all are of grain 1.

    Nodes of inverted elements are reordered. Raises CraftmeshError for other solid elements, for 4-node and
    10-node elements together, for points that do not have three coordinates, and for sets with names of
    lips (crack faces), because the opened crack gets these names.
    """
    lips = sorted(name for name in {*mesh.cell_sets, *mesh.field_data, *mesh.point_sets} if is_lip(name))
    if lips:
        raise CraftmeshError(
            f"the mesh has the lips {listed(lips)} of a crack opened before; open all cracks in one "
            "call, or rename these lips"
        )
    kinds = {block.type for block in mesh.cells}
    others = sorted(kinds - {*TETRAHEDRA, *FACES, *EDGES, "vertex"})
    if others or len(kinds & TETRAHEDRA.keys()) != 1:
        found = ", ".join(others or sorted(kinds & TETRAHEDRA.keys())) or "no tetrahedra"
        raise CraftmeshError(
            f"the mesh has {found}; expected tetrahedra of one kind, 'tetra' or 'tetra10', and no other "
            "cells than triangles, lines and vertices"
        )
    if mesh.points.ndim != 2 or mesh.points.shape[1] != 3:
        raise CraftmeshError(f"the mesh's points have the shape {mesh.points.shape}; expected (n, 3)")
    blocks = [block.data for block in mesh.cells if block.type in TETRAHEDRA]
    tets = np.concatenate(blocks).astype(np.int64)
    tets = np.where((tet_volumes(mesh.points, tets) < 0)[:, None], tets[:, _MIRRORED[tets.shape[1]]], tets)
    return TetMesh(mesh.points, tets, np.ones(len(tets), np.int32), dict(mesh.point_sets))


def foreign_facets(mesh: "Mesh", name: str) -> np.ndarray:
    """Return the corners (k, 3) of the triangles in the cell set or physical group `name`.

    Raises CraftmeshError if there are no such triangles.
    """
    found = [np.zeros((0, 3), np.int64)]
    in_set, tag = mesh.cell_sets.get(name), mesh.field_data.get(name)
    physical = mesh.cell_data.get(_TAGS[0])
    for number, block in enumerate(mesh.cells):
        if block.type not in FACES:
            continue
        if in_set is not None and in_set[number] is not None:
            found.append(block.data[np.asarray(in_set[number], np.int64), :3])
        elif in_set is None and tag is not None and physical is not None and tag[1] == 2:
            found.append(block.data[physical[number] == tag[0], :3])
    facets = np.concatenate(found)
    if not len(facets):
        known = ", ".join(sorted({*mesh.cell_sets, *mesh.field_data})) or "none"
        raise CraftmeshError(f"facets: the mesh has no set of triangles {name!r}; its sets are {known}")
    return facets


def foreign_with_crack(mesh: "Mesh", opened: TetMesh, parent: np.ndarray) -> "Mesh":
    """Return `mesh` on the opened nodes, with the lips' triangles as new cells at its end.

    parent (n,): the old node of each node of `opened`. Every lip (crack face) is a new block of triangles
    with normals out of the material, a cell set, and, if the mesh has physical groups, such a group. Lips
    and fronts are also point sets. Old triangles on the crack get the nodes of lip A, old lines the nodes
    of the element with the lowest number. Point data are copied from the old nodes; cell data of the new
    cells are 0, except Gmsh's group numbers.
    """
    with extra("formats"):
        from meshio import Mesh

    lips = {name: opened.outward_triangles(name) for name in opened.face_sets if is_lip(name)}
    kind = "triangle" if opened.tets.shape[1] == 4 else "triangle6"
    cells = [(block.type, data) for block, data in zip(mesh.cells, _cells(mesh, opened, parent))]
    new = [(kind, triangles) for triangles in lips.values()]
    cell_data = {name: _with_lips(name, blocks, new) for name, blocks in mesh.cell_data.items()}
    groups = dict(mesh.field_data)
    if _TAGS[0] in cell_data:
        groups |= {
            name: np.array([blocks[0], 2])
            for name, blocks in zip(lips, cell_data[_TAGS[0]][len(mesh.cells) :])
        }
    none = [np.zeros(0, np.int64)] * len(new)
    cell_sets = {name: [*blocks, *none] for name, blocks in mesh.cell_sets.items()}
    for number, name in enumerate(lips, len(mesh.cells)):
        cell_sets[name] = [np.zeros(0, np.int64)] * (len(cells) + len(new))
        cell_sets[name][number] = np.arange(len(lips[name]))
    return Mesh(
        opened.points,
        cells + new,
        point_data={name: values[parent] for name, values in mesh.point_data.items()},
        cell_data=cell_data,
        field_data=groups,
        point_sets=dict(opened.node_sets),
        cell_sets=cell_sets,
        gmsh_periodic=mesh.gmsh_periodic,
        info=mesh.info,
    )


def _with_lips(name: str, blocks: list[np.ndarray], new: list[tuple[str, np.ndarray]]) -> list[np.ndarray]:
    """Return the cell data `blocks` of a name, extended by arrays for the new cell blocks.

    new: type and cells of each new block. Values are 0, or new group numbers for Gmsh's tags.
    """
    first = 1 + max((int(block.max(initial=0)) for block in blocks), default=0) if name in _TAGS else 0
    like = np.asarray(blocks[0])
    values = [first + k if name in _TAGS else 0 for k in range(len(new))]
    return [
        *blocks,
        *(np.full((len(cell[1]), *like.shape[1:]), value, like.dtype) for cell, value in zip(new, values)),
    ]


def _cells(mesh: "Mesh", opened: TetMesh, parent: np.ndarray) -> list[np.ndarray]:
    """Return the cells (c, w) of each of the mesh's blocks on the opened nodes.

    Cells that are no part of a tetrahedron keep their nodes.
    """
    lips = [faces for name, faces in opened.face_sets.items() if is_lip(name) and name.endswith("A")]
    lip_a = np.concatenate(lips) @ np.array([4, 1])
    rows = np.concatenate([lip_a, np.arange(4 * len(opened.tets))])
    old = parent[opened.tets]
    result, first = [], 0
    for block in mesh.cells:
        data = np.asarray(block.data, np.int64)
        if block.type in TETRAHEDRA:
            every = np.arange(len(data))
            data, first = _moved(data, opened.tets, old, every, first + every), first + len(data)
        elif block.type in FACES and len(data):
            groups = group_triples(np.concatenate([half_face_corners(old, rows), data[:, :3]]))
            data = _moved(data, opened.tets, old, *_holders(groups, len(rows), rows // 4))
        elif block.type in EDGES and len(data):
            edges = tet_edges(old)
            groups = group_edges(np.concatenate([edges, data[:, :2]]))
            data = _moved(data, opened.tets, old, *_holders(groups, len(edges), np.arange(len(edges)) // 6))
        result.append(data)
    return result


def _holders(groups: RowGroups, count: int, tet: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the cells (k,) that are a face or edge of a tetrahedron, and the tetrahedron (k,) of each.

    groups: groups of equal rows, of which the first `count` are faces or edges of tetrahedra and the others
    are the cells; tet (count,): the tetrahedron of each face or edge.
    """
    lead = groups.lead[groups.index[count:]]
    cells = np.flatnonzero(lead < count)
    return cells, tet[lead[cells]]


def _moved(
    data: np.ndarray, tets: np.ndarray, old: np.ndarray, cells: np.ndarray, holder: np.ndarray
) -> np.ndarray:
    """Return the cells `data` (c, w) with new nodes in the rows `cells`.

    Each of these cells gets the nodes of the tetrahedron `holder` of which it is a part. tets: the
    tetrahedra on new nodes; old: on their old nodes.
    """
    place = (old[holder][:, None, :] == data[cells][:, :, None]).argmax(axis=2)
    result = data.copy()
    result[cells] = np.take_along_axis(tets[holder], place, axis=1)
    return result
