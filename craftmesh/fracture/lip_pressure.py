"""Tractions on the lips: given ones, and contact tractions from the nodal forces between touching lips."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from scipy.sparse import coo_array, csr_array, diags_array

from craftmesh.mechanics.load import Traction, point_vectors
from craftmesh.mesh.front_curve import unit
from craftmesh.mesh.integration import corner_shares, face_points, triangle_points
from craftmesh.mesh.lips import LipPairs, lip_pairs
from craftmesh.mesh.mesh_sets import lip_faces
from craftmesh.mesh.tet_connectivity import face_nodes, group_edges
from craftmesh.types import TetMesh


@dataclass(frozen=True, eq=False)
class FaceTractions:
    """Tractions (f, q, 3) at the points of `face_points` on faces (f, 2) of a mesh.

    Tractions of a face that occurs several times are added.
    """

    faces: np.ndarray
    traction: np.ndarray

    def on(self, faces: np.ndarray) -> np.ndarray:
        """Return tractions (k, q, 3) at the q points of each face (k, 2), 0 on faces without traction."""
        key, own = (rows @ np.array([4, 1]) for rows in (faces, self.faces))
        order = np.argsort(key)
        first = np.searchsorted(key, own, sorter=order)
        there = first < len(key)
        there[there] = key[order[first[there]]] == own[there]
        found = np.zeros((len(faces), *self.traction.shape[1:]))
        np.add.at(found, order[first[there]], self.traction[there])
        return found

    def at(self, mesh: TetMesh, nodes: np.ndarray) -> np.ndarray:
        """Return a mask (k,) of nodes that are corners of faces with a traction."""
        bear = face_nodes(mesh.tets[:, :4], self.faces)[self.traction.any(axis=(1, 2))]
        return np.isin(nodes, bear)


NO_TRACTIONS = FaceTractions(np.zeros((0, 2), np.int64), np.zeros((0, len(triangle_points()[1]), 3)))


def lip_tractions(mesh: TetMesh, given: Sequence[Traction], contact: np.ndarray | None) -> FaceTractions:
    """Return all tractions on the lips (crack faces) of a 10-node mesh: the given ones and contact's.

    contact (n, 3): forces of touching lips on each other, None without contact.
    """
    parts = [contact_tractions(mesh, contact)]
    for part in given:
        area = face_points(mesh.points[face_nodes(mesh.tets, part.faces)]).area
        parts.append(FaceTractions(part.faces, point_vectors(part, area)))
    faces, traction = ([getattr(part, name) for part in parts] for name in ("faces", "traction"))
    return FaceTractions(np.concatenate(faces), np.concatenate(traction))


def contact_tractions(mesh: TetMesh, contact: np.ndarray | None) -> FaceTractions:
    """Return the tractions of contact on both lips of a 10-node mesh.

    contact (n, 3): nodal forces of touching lips on each other; None: no tractions. Pressure and friction
    are linear on each facet and continuous. Their work in displacements by the shape functions fits the
    work of the forces.
    """
    if contact is None or not contact.any():
        return NO_TRACTIONS
    pairs = lip_pairs(mesh)
    force = contact[pairs.nodes[:, 0]]
    push, friction = pairs.split(force)
    fitted = _fitted(mesh, pairs, np.column_stack([push, friction]))
    touching = ((push != 0)[pairs.facets] & (pairs.facets >= 0)).any(axis=1)
    fitted, turn = fitted[touching], pairs.turn[touching, :3]
    faces = pairs.faces[:, touching].reshape(-1, 2)
    other = np.empty_like(fitted)
    np.put_along_axis(other, turn[:, :, None], fitted * [1, -1, -1, -1], axis=1)
    nodes = mesh.points[face_nodes(mesh.tets, faces)]
    at = face_points(nodes)
    shares = corner_shares(nodes[:, :3], at.place)
    values = shares @ np.concatenate([fitted, other])
    return FaceTractions(faces, values[:, :, 1:] - values[:, :, :1] * unit(at.area))


def lips_touch(mesh: TetMesh, contact: np.ndarray | None) -> np.ndarray:
    """Return a mask (n,), False at nodes of open facets of lip A; all False if `contact` is None.

    A facet is closed if contact forces (n, 3) act on all its nodes that are not on lip B too. Nodes that
    are not on lip A are True, so the mask is meant for nodes of the front.
    """
    touch = np.full(len(mesh.points), contact is not None)
    if contact is None:
        return touch
    a, b = (face_nodes(mesh.tets, faces) for faces in lip_faces(mesh.face_sets))
    bears = (contact != 0).any(axis=1)
    shut = (np.isin(a, b) | bears[a]).all(axis=1)
    touch[a[~shut]] = False
    return touch


def _fitted(mesh: TetMesh, pairs: LipPairs, force: np.ndarray) -> np.ndarray:
    """Return the tractions (f, 3, c) at the corners of facets that fit given forces between the lips.

    force (p, c): components of the force on the first node of each pair, opposite each other on the lips,
    each fitted by itself. The tractions are fitted by least squares, and their bends are held small.
    """
    corners = face_nodes(mesh.tets[:, :4], pairs.faces[0])
    # one unknown per pair of nodes, because a node is on several lips where cracks cross, or per front node
    key = np.where(pairs.facets[:, :3] < 0, len(force) + corners, pairs.facets[:, :3])
    known_keys, unknown = np.unique(key, return_inverse=True)
    unknown = unknown.reshape(corners.shape)
    rows = np.repeat(pairs.facets[:, :, None], 3, axis=2)
    columns = np.repeat(unknown[:, None, :], rows.shape[1], axis=1)
    known = rows >= 0
    shape = len(force), len(known_keys)
    work = coo_array((_works(mesh, pairs)[known], (rows[known], columns[known])), shape).tocsr()
    area = abs(work).sum(axis=1)
    bends = _bends(mesh.points[corners], unknown, len(known_keys))
    weighed = diags_array(1 / area) @ work
    # Near the front, forces err by 2 % where lips slide. K_I of penny cracks under pressure, with five
    # edges to the radius, errs by at most 1.9 % of K_II without the bends, by 0.9 % with them, and by 0.6 %
    # with nine times their weight. With that weight, K_I of a bent body errs on the closed half of its
    # crack by 2 % of the open half's K_I in the mean. K_I of a pressure 0.2 + 1.6 r^2 on a penny of radius
    # 1 errs by 10 % of that of a pressure 1.8, now by 3 %.
    normal = weighed.T @ work + bends.T @ bends
    return scipy.sparse.linalg.spsolve(normal.tocsc(), weighed.T @ force)[unknown]


def _bends(points: np.ndarray, corner: np.ndarray, count: int) -> csr_array:
    """Return the matrix (e, count) that gives the change of slope at edges from values at facets' corners.

    points (f, 3, 3): the corners; corner (f, 3): the index, below `count`, of each corner's value. A row
    gives the change of slope across an edge, multiplied by the edge's length and by the square root of the
    summed area of its two facets. These factors make bends of large facets weigh more in the fit.
    """
    groups = group_edges(np.stack([corner, np.roll(corner, -1, axis=1)], axis=2).reshape(-1, 2))
    facet, edge = np.divmod(groups.pairs, 3)
    ends = np.stack([points[facet, (edge + k) % 3] for k in range(3)], axis=2)
    along = ends[:, :, 1] - ends[:, :, 0]
    length = np.linalg.norm(along, axis=2, keepdims=True)
    share = ((ends[:, :, 2] - ends[:, :, 0]) * along).sum(axis=2, keepdims=True) / length**2
    height = np.linalg.norm(ends[:, :, 2] - ends[:, :, 0] - share * along, axis=2, keepdims=True)
    slope = np.concatenate([share - 1, -share, np.ones_like(share)], axis=2) / height
    scale = length[:, :1, :] * np.sqrt(0.5 * (length * height).sum(axis=1, keepdims=True))
    columns = np.stack([corner[facet, (edge + k) % 3] for k in range(3)], axis=2)
    rows = np.broadcast_to(np.arange(len(columns))[:, None, None], columns.shape)
    place = rows.ravel(), columns.ravel()
    return coo_array(((scale * slope).ravel(), place), (len(columns), count)).tocsr()


def _works(mesh: TetMesh, pairs: LipPairs) -> np.ndarray:
    """Return the integrals (f, 6, 3), over facets of lip A, of 6 shape functions times 3 hat functions.

    The hat functions are the barycentric coordinates, linear functions that are 1 at one corner.
    """
    nodes = mesh.points[face_nodes(mesh.tets, pairs.faces[0])]
    at = face_points(nodes)
    shares = corner_shares(nodes[:, :3], at.place)
    return at.value.T @ (np.linalg.norm(at.area, axis=2, keepdims=True) * shares)
