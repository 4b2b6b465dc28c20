"""Stresses on faces, as vectors at their corners and as forces at their nodes."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from craftmesh.mesh.integration import face_shape
from craftmesh.mesh.tet_connectivity import FACE_CORNERS, FACE_EDGES, face_nodes
from craftmesh.surface.measure import area_vectors
from craftmesh.types import TetMesh

# Where the deck's solvers integrate over faces of C3D4 and C3D10: shares of the second and third corner.
_MIDDLE = np.array([[1 / 3, 1 / 3]])
_THREE = np.array([[1 / 6, 1 / 6], [2 / 3, 1 / 6], [1 / 6, 2 / 3]])


@dataclass(frozen=True, eq=False)
class Traction:
    """A stress on a face set: faces (f, 2) of elements and sides.

    axis: the one (0, 1, 2) along which it acts; None: the outward normals, tension > 0. stress: one for
    all, or those (f, 3) at the corners of the faces, linear between them.
    """

    faces: np.ndarray
    stress: float | np.ndarray
    name: str
    axis: int | None = None


def corner_vectors(traction: Traction, mesh: TetMesh) -> np.ndarray:
    """Return the traction (f, 3, 3) at the corners of its faces."""
    if traction.axis is not None:
        way = np.broadcast_to(np.eye(3)[traction.axis], (len(traction.faces), 3))
    else:
        way = -area_vectors(mesh.points, face_nodes(mesh.tets[:, :4], traction.faces))
        way /= np.linalg.norm(way, axis=1, keepdims=True)
    stress = np.broadcast_to(traction.stress, (len(way), 3))
    return stress[:, :, None] * way[:, None, :]


def nodal_forces(tractions: Iterable[Traction], mesh: TetMesh) -> np.ndarray:
    """Return the forces (n, 3) of tractions on a mesh, consistent with its shape functions."""
    forces = np.zeros(mesh.points.shape)
    is_linear = mesh.tets.shape[1] == 4
    nodes_of = FACE_CORNERS if is_linear else np.hstack([FACE_CORNERS, 4 + FACE_EDGES])
    for traction in tractions:
        tets, sides = traction.faces.T
        nodes = mesh.tets[tets[:, None], nodes_of[sides]]
        places = mesh.points[nodes]
        for s, t in (_MIDDLE if is_linear else _THREE).tolist():
            values, slopes = face_shape(s, t, is_linear)
            u, v = np.einsum("ka,fki->afi", slopes, places)
            way = -np.cross(u, v)  # outward, by the order of FACE_CORNERS
            if traction.axis is not None:
                way = np.linalg.norm(way, axis=1, keepdims=True) * np.eye(3)[traction.axis]
            weight = 0.5 if is_linear else 1 / 6
            if isinstance(traction.stress, np.ndarray):
                way = way * (traction.stress @ [1 - s - t, s, t])[:, None]
            else:
                weight *= traction.stress
            np.add.at(forces, nodes, weight * values[:, None] * way[:, None, :])
    return forces
