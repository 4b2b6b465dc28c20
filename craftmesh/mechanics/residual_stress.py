"""Residual stress: a field in the body without its crack, whose release puts tractions on the lips."""

from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.mechanics.lips import interpolated, lips_of
from craftmesh.mechanics.load import Traction
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mesh.front_curve import unit
from craftmesh.mesh.integration import face_points
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.surface.side_data import covered, notes_on_place
from craftmesh.types import TetMesh


@dataclass(frozen=True, eq=False)
class StressField:
    """Stresses (k, 6) as 11, 22, 33, 12, 13, 23 at points (k, d).

    axes (d,): the axes (0, 1, 2) of the points' coordinates; the field is the same along all others.
    """

    points: np.ndarray
    axes: tuple[int, ...]
    stress: np.ndarray

    def at(self, places: np.ndarray) -> np.ndarray:
        """Return stresses (n, 3, 3) at places (n, 3), `interpolated` between the points around each.

        Raises CraftmeshError for a place farther from the points than these from their neighbours.
        """
        if len(self.points) == 1:
            return np.broadcast_to(self.stress[0, COMPONENT], (len(places), 3, 3))
        along, count = places[:, self.axes], 3 ** len(self.axes)  # a point of a grid and its neighbours
        is_covered, where = covered(along, self.points, count)
        if not is_covered.all():
            raise CraftmeshError(
                f"residual_stress: has no value at {rounded_values(places[~is_covered][0])} on the "
                f"crack, {where}; "
                "give values at all places that the crack may reach, 0 where there is no stress"
            )
        return interpolated(self.points, self.stress, along, count)[:, COMPONENT]


def residual_lips(mesh: TetMesh, field: StressField) -> tuple[Traction, ...]:
    """Return the tractions on lips that, with the field itself, leave the lips free.

    These are -sigma n, n the outward normal of each lip. By superposition K of these tractions is K of the
    stress. Raises CraftmeshError for a mesh without lips and a field that does not cover them.
    """
    if len(field.points) > 1:
        notes_on_place("residual_stress", field.points, mesh.box[:, field.axes])
    found = []
    for name, faces in lips_of(mesh, "residual_stress").items():
        at = face_points(mesh.points[face_nodes(mesh.tets, faces)])
        stress = field.at(at.place.reshape(-1, 3)).reshape(*at.place.shape, 3)
        pull = -(stress @ unit(at.area)[..., None])[..., 0]
        found += [Traction(faces, pull[..., axis], name, axis) for axis in range(3)]
    return tuple(found)
