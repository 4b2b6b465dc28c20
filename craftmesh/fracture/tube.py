"""The tube around a front, its integration domain: its radius, elements and free faces."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.fracture.lip_pressure import FaceTractions
from craftmesh.fracture.options import LEAST_RADIUS
from craftmesh.fracture.segments import SAMPLES, Segments, material_numbers
from craftmesh.mesh.front_curve import FrontCurve, arc_lengths, ways_along
from craftmesh.mesh.front_frames import Front
from craftmesh.mesh.mesh_sets import lip_faces, own_lips
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.surface.measure import area_vectors
from craftmesh.types import TetMesh

# Largest radius of the tube over the front's bend radius, so that the tube ends before the centre of
# curvature.
OF_CURVATURE = 0.8
# Ratio of the length along a front to the straight distance, above which two of its nodes are strangers,
# parts that the tube must not reach both. Between opposite points of a circle it is 1.6.
STRANGERS = 2.5


def radii(
    fronts: list[np.ndarray], number: int, closed: bool, curve: FrontCurve, sizes: np.ndarray, radius: float
) -> np.ndarray:
    """Return the tube's radius (k,) at the nodes of front `number`; fronts: points (k, 3) of each front.

    sizes (k,): local sizes, mean edge lengths nearby; radius: the wanted radius in local sizes. The result
    is smaller where the front bends, or where another front, or a part of this front that counts as a
    stranger, is near, but at least LEAST_RADIUS local sizes.
    """

    points = fronts[number]
    s, total = arc_lengths(points, closed)
    others = [own for k, own in enumerate(fronts) if k != number]
    distance = scipy.spatial.distance.cdist(points, points)
    is_stranger = ways_along(s, s, total, closed) > STRANGERS * distance
    room = np.where(is_stranger, distance, np.inf).min(axis=1)
    if others:
        room = np.minimum(scipy.spatial.KDTree(np.concatenate(others)).query(points)[0], room)
    room = room - sizes
    room = np.minimum(room, OF_CURVATURE * curve.bend_radius(s))
    return np.clip(room, LEAST_RADIUS * sizes, radius * sizes)


class SolvedMesh(NamedTuple):
    """A 10-node mesh, the displacements (n, 3) of its nodes, and all other data for K of its fronts.

    stiffness (g, 6, 6) and eigenstrain (g, 3, 3) of grains (g,), ascending ids; loaded: face sets with
    unknown tractions; tractions: known tractions on lips (crack faces); touch (n,): mask of nodes at which
    the lips are closed; temperature (n,): factor of the eigenstrains at the nodes.
    """

    mesh: TetMesh
    displacement: np.ndarray
    grains: np.ndarray
    stiffness: np.ndarray
    eigenstrain: np.ndarray
    loaded: Collection[str]
    tractions: FaceTractions
    touch: np.ndarray
    temperature: np.ndarray


@dataclass(frozen=True, eq=False)
class Tube:
    """The elements around a front, their nodes, and the outer faces that the virtual extension q may move.

    nodes (n,): ids in the mesh; points, displacement (n, 3): displacements without rigid motion;
    temperature (n,): factor of the eigenstrains; s (n,):
    arc lengths of the nearest points on the front, distance (n,) to them, binormal (n, 3) and segment (n,)
    there. tets (e, 10): rows of nodes; grain (e,): rows of stiffness (g, 6, 6) and eigenstrain (g, 3, 3);
    side (e,): 1 on the side of lip A, -1 on the side of lip B; shift (c, 3, 3): the eigenstrain at the
    front in each segment. faces (f, 2): outer faces (element, face); lip faces that touch the front are
    among them only if they have tractions; face_side (f,): like side; at_front (f, 3): mask of the corners
    of lip faces on the front; loaded (f,): mask of faces that may have unknown tractions; traction (f, q,
    3): known tractions at the points of `face_points`.
    """

    nodes: np.ndarray
    points: np.ndarray
    displacement: np.ndarray
    temperature: np.ndarray
    s: np.ndarray
    distance: np.ndarray
    binormal: np.ndarray
    segment: np.ndarray
    tets: np.ndarray
    grain: np.ndarray
    side: np.ndarray
    stiffness: np.ndarray
    eigenstrain: np.ndarray
    shift: np.ndarray
    faces: np.ndarray
    face_side: np.ndarray
    at_front: np.ndarray
    loaded: np.ndarray
    traction: np.ndarray

    def others(self, segments: Segments, radius: np.ndarray) -> np.ndarray:
        """Return arc lengths s (k,) of nodes with another material than the front has at s.

        They are nodes, nearer to the front than radius (n,), of elements whose stiffness or eigenstrain
        differs from that of the node's segment.
        """
        number = material_numbers(np.concatenate([_constants(self), _constants(segments)]))
        of_grain, of_segment = np.split(number, [len(self.eigenstrain)])
        is_other = of_grain[self.grain][:, None] != of_segment[self.segment[self.tets]]
        return self.s[np.unique(self.tets[is_other & (self.distance < radius)[self.tets]])]


def _constants(of: Tube | Segments) -> np.ndarray:
    """Return the constants (k, 45), of stiffness and eigenstrain, of a tube's grains or of segments."""
    count = len(of.stiffness)
    return np.hstack([of.stiffness.reshape(count, -1), of.eigenstrain.reshape(count, -1)])


def tube_of(solved: SolvedMesh, front: Front, segments: Segments, reach: float) -> Tube:
    """Return the tube of elements with a corner nearer to the front than `reach`."""
    mesh = solved.mesh
    chosen = _elements_near(mesh, front.curve, reach)
    nodes, tets = np.unique(mesh.tets[chosen], return_inverse=True)
    points = mesh.points[nodes]
    s, distance, binormal = _nearest(front.curve, points)
    lips = own_lips(mesh.face_sets, mesh.tets[:, :4], front.corners)
    side = _sides(mesh, chosen, lips)
    return Tube(
        nodes,
        points,
        without_rigid_motion(points, solved.displacement[nodes]),
        solved.temperature[nodes],
        s,
        distance,
        binormal,
        segments.at(s),
        tets.reshape(-1, 10),
        np.searchsorted(solved.grains, mesh.grain[chosen]),
        side,
        solved.stiffness,
        solved.eigenstrain,
        segments.eigenstrain,
        *_faces(solved, chosen, front, side, lips.keys()),
    )


def without_rigid_motion(points: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Return displacements (n, 3) of points (n, 3) less their mean shift and (linearized) rotation.

    Rigid motions do not change K, but large ones would add integration errors.
    """
    place, moved = points - points.mean(axis=0), displacement - displacement.mean(axis=0)
    gradient = np.linalg.solve(place.T @ place, place.T @ moved)
    return moved - 0.5 * place @ (gradient - gradient.T)


def _elements_near(mesh: TetMesh, curve: FrontCurve, reach: float) -> np.ndarray:
    """Return the elements (e,) with a corner nearer to the curve than `reach`."""
    samples = curve.frames(_samples(curve))[0]
    gap = np.linalg.norm(np.diff(samples, axis=0), axis=1).max()
    low, high = samples.min(axis=0) - reach - gap, samples.max(axis=0) + reach + gap
    near = np.flatnonzero(((mesh.points > low) & (mesh.points < high)).all(axis=1))
    is_near = np.zeros(len(mesh.points), bool)
    is_near[near] = _nearest(curve, mesh.points[near])[1] < reach
    return np.flatnonzero(is_near[mesh.tets[:, :4]].any(axis=1))


def _samples(curve: FrontCurve) -> np.ndarray:
    return np.linspace(0, curve.length, SAMPLES * curve.pieces + 1)


def _nearest(curve: FrontCurve, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return arc lengths, distances (k,) and binormals (k, 3) of the curve's points nearest to `points`."""

    at = _samples(curve)
    s = curve.nearest(points, at[scipy.spatial.KDTree(curve.frames(at)[0]).query(points)[1]])
    nearest, _, _, binormal = curve.frames(s)
    return s, np.linalg.norm(points - nearest, axis=1), binormal


def _sides(mesh: TetMesh, chosen: np.ndarray, own: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return 1 for elements (e,) on the side of lip A of the front's own crack, -1 on the side of lip B.

    own: the face sets of this crack's lips. An element that touches only one lip is on its side. For other
    elements the position of their centre relative to the nearest facet of lip A decides.
    """

    on_lip = np.zeros((2, len(mesh.points)), bool)
    lips = lip_faces(own)
    for row, faces in zip(on_lip, lips):
        row[face_nodes(mesh.tets, faces)] = True
    a, b = ((on_lip[i] & ~on_lip[1 - i])[mesh.tets[chosen]].any(axis=1) for i in range(2))
    facets = face_nodes(mesh.tets[:, :4], lips[0])
    normals, centres = area_vectors(mesh.points, facets), mesh.points[facets].mean(axis=1)
    middle = mesh.points[mesh.tets[chosen, :4]].mean(axis=1)
    _, near = scipy.spatial.KDTree(centres).query(middle)
    above = ((middle - centres[near]) * normals[near]).sum(axis=1) > 0
    return np.where(a & ~b, 1.0, np.where(b & ~a, -1.0, np.where(above, 1.0, -1.0)))


def _faces(
    solved: SolvedMesh, chosen: np.ndarray, front: Front, side: np.ndarray, lips: Collection[str]
) -> tuple[np.ndarray, ...]:
    """Return the outer faces (f, 2) of the chosen elements, then face_side, at_front, loaded and traction.

    `Tube` describes these arrays. The element in a face is its row in `chosen`. lips: names of the lip
    face sets of the front's own crack; side (e,): side of each chosen element.
    """
    mesh = solved.mesh
    row = np.full(len(mesh.tets), -1)
    row[chosen] = np.arange(len(chosen))
    is_front = np.zeros(len(mesh.points), bool)
    is_front[front.corners] = True
    parts = []
    for name, faces in mesh.face_sets.items():
        faces = faces[row[faces[:, 0]] >= 0]
        lip, traction = name in lips, solved.tractions.on(faces)
        touches = is_front[face_nodes(mesh.tets[:, :4], faces)] & lip
        own = np.full(len(faces), 1.0 if name.endswith("A") else -1.0) if lip else side[row[faces[:, 0]]]
        part = faces, own, touches, np.full(len(faces), name in solved.loaded), traction
        kept = ~touches.any(axis=1) | traction.any(axis=(1, 2))
        parts.append([values[kept] for values in part])
    faces, *rest = (np.concatenate(values) for values in zip(*parts))
    return np.column_stack([row[faces[:, 0]], faces[:, 1]]), *rest
