"""Gmsh's files (.msh, format 2.2, binary): grains, face sets and node sets as physical groups."""

import os

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.types import TetMesh

_CELLS = {4: ("tetra", "triangle"), 10: ("tetra10", "triangle6")}


def write_msh(path: str | os.PathLike, mesh: TetMesh) -> None:
    """Write the mesh through meshio; every set is a physical group.

    Volumes GRAIN_<id>, whose tag is the grain's id; surfaces of triangles with normals out of their
    elements, one group per face set; points, one group per node set in its order. Node sets called as
    a face set get _NODES after their names, for meshio's groups of all dimensions share one list of names.
    Elements come first and keep the deck's numbers. Empty sets are left out.
    """
    from meshio import Mesh
    from meshio.gmsh import write

    solid, face = _CELLS[mesh.tets.shape[1]]
    cells, tags = [(solid, mesh.tets)], [mesh.grain]
    groups = {f"GRAIN_{grain}": np.array([grain, 3]) for grain in np.unique(mesh.grain).tolist()}
    for k, (name, faces) in enumerate(mesh.face_sets.items(), 1):
        if len(faces):
            cells.append((face, mesh.outward_triangles(name)))
            tags.append(np.full(len(faces), k, np.int32))
            groups[name] = np.array([k, 2])
    for k, (name, nodes) in enumerate(mesh.node_sets.items(), 1):
        if len(nodes):
            cells.append(("vertex", nodes[:, None]))
            tags.append(np.full(len(nodes), k, np.int32))
            groups[f"{name}_NODES" if name in mesh.face_sets else name] = np.array([k, 0])
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    with atomic_path(path) as temporary:
        write(temporary, Mesh(mesh.points, cells, cell_data=data, field_data=groups), "2.2", binary=True)
