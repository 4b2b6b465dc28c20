"""Tractions that a load puts on the lips (crack faces)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.load import Load, Traction, point_vectors
from craftmesh.mechanics.point_fields import interpolated
from craftmesh.mesh.integration import face_points
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.side_data import covered, notes_on_place
from craftmesh.types import TetMesh

# Number of nearest points of the field that give the value at a position: enough to fit a plane.
_NEAREST = 8


@dataclass(frozen=True, eq=False)
class LipField:
    """A load on lips (crack faces), given at points (k, 3).

    pressure (k,), positive where it opens the crack; traction (k, 3) on lip A, with its opposite on lip B.
    """

    points: np.ndarray
    pressure: np.ndarray
    traction: np.ndarray

    def at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return pressure (n,) and traction (n, 3) at places (n, 3), interpolated by `interpolated`.

        A value lies on a plane fitted to the 8 nearest points' values, and within their range.
        """
        values = np.column_stack([self.pressure, self.traction])
        found = interpolated(self.points, values, places, _NEAREST)
        return found[:, 0], found[:, 1:]


def loaded_lips(
    mesh: TetMesh, pressure: float, traction: Sequence[float] = (), field: LipField | None = None
) -> tuple[Traction, ...]:
    """Return the tractions on all lips of a mesh, by a uniform pressure, a uniform traction and a field.

    Positive pressures open the cracks. traction (3,): on lips A, with its opposite on lips B. Components
    that are 0 everywhere are left out. Raises CraftmeshError for a mesh without lips, and for a field that
    lies elsewhere or does not cover them.
    """
    found = []
    lips = lips_of(mesh, "lip_pressure")
    if field is not None:
        _refuse_uncovered(mesh, np.concatenate(list(lips.values())), field)
    for name, faces in lips.items():
        sign = 1.0 if name.endswith("A") else -1.0
        parts: list[tuple[int | None, float | np.ndarray]] = [(None, -float(pressure))]
        places = face_points(mesh.points[face_nodes(mesh.tets, faces)]).place
        parts += [(k, np.broadcast_to(sign * pull, places.shape[:2])) for k, pull in enumerate(traction)]
        if field is not None:
            pressures, pulls = field.at(places.reshape(-1, 3))
            parts.append((None, -pressures.reshape(places.shape[:2])))
            parts += [(k, sign * pull.reshape(places.shape[:2])) for k, pull in enumerate(pulls.T)]
        found += [Traction(faces, stress, name, axis) for axis, stress in parts if np.any(stress)]
    return tuple(found)


def lips_of(mesh: TetMesh, key: str) -> dict[str, np.ndarray]:
    """Return the faces (f, 2) of each lip; raise CraftmeshError, beginning with `key`, if there is none."""
    lips = {name: faces for name, faces in mesh.face_sets.items() if is_lip(name) and len(faces)}
    if not lips:
        raise CraftmeshError(f"{key}: the mesh has no lips; give a mesh with an opened crack, or no load")
    return lips


def _refuse_uncovered(mesh: TetMesh, faces: np.ndarray, field: LipField) -> None:
    """Raise CraftmeshError if a field is off the body, or has no points near one of the faces (f, 2)."""
    notes_on_place("lip_field", field.points, mesh.box)
    corners = mesh.points[face_nodes(mesh.tets[:, :4], faces)]
    edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    near, where = covered(corners.reshape(-1, 3), field.points, _NEAREST, np.repeat(edge, 3))
    is_covered = near.reshape(-1, 3).any(axis=1)
    if not is_covered.all():
        area = np.linalg.norm(area_vectors(mesh.points, face_nodes(mesh.tets[:, :4], faces)), axis=1)
        raise CraftmeshError(
            f"lip_field: its points cover {area[is_covered].sum() / area.sum():.1%} of the lips, {where}; "
            "give values on all lips, 0 where nothing acts (for a growing crack, as far as its lips may "
            "reach), or give lip_pressure instead"
        )


def on_lips(load: Load | None) -> tuple[Traction, ...]:
    """Return the tractions of a load that act on lips."""
    return () if load is None else tuple(pulled for pulled in load.pulled if is_lip(pulled.name))


def mean_traction(load: Load | None, mesh: TetMesh) -> float:
    """Return the mean magnitude of the tractions on lips, weighted by area; 0 without tractions.

    Tractions on the same lip are added first: its pressure, and the components along each axis.
    """
    pull: dict[str, np.ndarray] = {}
    area: dict[str, np.ndarray] = {}
    for part in on_lips(load):
        at = face_points(mesh.points[face_nodes(mesh.tets, part.faces)])
        pull[part.name] = pull.get(part.name, 0.0) + point_vectors(part, at.area)
        area[part.name] = np.linalg.norm(at.area, axis=2)
    if not pull:
        return 0.0
    size = np.linalg.norm(np.concatenate(list(pull.values())), axis=2)
    return float(np.average(size, weights=np.concatenate(list(area.values()))))
