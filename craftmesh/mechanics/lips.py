"""Tractions that a load puts on the lips of cracks."""

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.load import Load
from craftmesh.mechanics.tractions import Traction, corner_vectors
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.surface.measure import area_vectors
from craftmesh.types import TetMesh


def pressed_lips(mesh: TetMesh, pressure: float) -> tuple[Traction, ...]:
    """Return the tractions of a pressure on all lips, which opens the cracks where it is positive.

    Raises CraftmeshError for a mesh without lips.
    """
    lips = {name: faces for name, faces in mesh.face_sets.items() if is_lip(name) and len(faces)}
    if not lips:
        raise CraftmeshError(
            "lip_pressure: the mesh has no lips; give one with an opened crack, or lip_pressure 0"
        )
    return tuple(Traction(faces, -float(pressure), name) for name, faces in lips.items())


def on_lips(load: Load | None) -> tuple[Traction, ...]:
    """Return the tractions of a load that act on lips."""
    return () if load is None else tuple(pulled for pulled in load.pulled if is_lip(pulled.name))


def mean_traction(load: Load | None, mesh: TetMesh) -> float:
    """Return the mean size of the tractions on lips, 0 without: the stress that they stand for."""
    found = on_lips(load)
    if not found:
        return 0.0
    faces = np.concatenate([part.faces for part in found])
    pull = np.concatenate([corner_vectors(part, mesh).mean(axis=1) for part in found])
    area = area_vectors(mesh.points, face_nodes(mesh.tets[:, :4], faces))
    return float(np.average(np.linalg.norm(pull, axis=1), weights=np.linalg.norm(area, axis=1)))
