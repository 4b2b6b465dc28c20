"""Residual stress: a field in the body without its crack, whose release puts tractions on the lips."""

from craftmesh.mechanics.lips import lips_of
from craftmesh.mechanics.load import Traction
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mechanics.point_fields import PointField
from craftmesh.mesh.front_curve import unit
from craftmesh.mesh.integration import face_points
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.types import TetMesh


def residual_lips(mesh: TetMesh, field: PointField) -> tuple[Traction, ...]:
    """Return the tractions on lips that, with a field of stresses 11, 22, 33, 12, 13, 23, leave them free.

    These are -sigma n, n the outward normal of each lip. By superposition K of these tractions is K of the
    stress. Raises CraftmeshError for a mesh without lips and a field that does not cover them.
    """
    found = []
    for name, faces in lips_of(mesh, "residual_stress").items():
        at = face_points(mesh.points[face_nodes(mesh.tets, faces)])
        values = field.at(
            at.place.reshape(-1, 3),
            "residual_stress",
            mesh.box,
            "at all places that the crack may reach, 0 where there is no stress",
        )
        stress = values[:, COMPONENT].reshape(*at.place.shape, 3)
        pull = -(stress @ unit(at.area)[..., None])[..., 0]
        found += [Traction(faces, pull[..., axis], name, axis) for axis in range(3)]
    return tuple(found)
