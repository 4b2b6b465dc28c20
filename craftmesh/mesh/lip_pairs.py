"""Nodes of a crack's two lips that lie in one place: where the lips meet when they close."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mesh.mesh_sets import lip_faces
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.surface.measure import area_vectors
from craftmesh.types import TetMesh


@dataclass(frozen=True, eq=False)
class LipPairs:
    """nodes (p, 2): on lip A and on lip B; normal (p, 3): unit, from lip B to lip A.

    faces (2, f, 2): those of lip A that lie on one of lip B, and that one; facets (f, 3 or 6): the pair of
    each of their nodes, in the order of lip A's `face_nodes`, -1 at nodes that the lips share: those of the
    front; turn (f, 3 or 6): the places of the same nodes among lip B's.
    """

    nodes: np.ndarray
    normal: np.ndarray
    faces: np.ndarray
    facets: np.ndarray
    turn: np.ndarray

    def gaps(self, displacement: np.ndarray) -> np.ndarray:
        """Return how far (p,) a displacement (n, 3) parts the lips; negative where they overlap."""
        a, b = self.nodes.T
        return np.einsum("pi,pi->p", self.normal, displacement[a] - displacement[b])

    def forces(self, push: np.ndarray, shape: tuple) -> np.ndarray:
        """Return the forces (n, 3) at the nodes of that shape whose pairs push apart by `push` (p,)."""
        out = np.zeros(shape)
        np.add.at(out, self.nodes[:, 0], push[:, None] * self.normal)
        np.add.at(out, self.nodes[:, 1], -push[:, None] * self.normal)
        return out


def lip_pairs(mesh: TetMesh) -> LipPairs:
    """Return the pairs of all cracks of a mesh; lips that do not lie on each other have none."""
    faces = lip_faces(mesh.face_sets)
    nodes = [face_nodes(mesh.tets, rows) for rows in faces]
    place = _places(mesh.points, nodes)
    rows = [np.sort(own[:, :3], axis=1) for own in place]
    _, key = np.unique(np.concatenate(rows), axis=0, return_inverse=True)
    of_a, of_b = np.split(key.ravel(), [len(rows[0])])
    _, at_a, at_b = np.intersect1d(of_a, of_b, return_indices=True)
    order = np.argsort(at_a)
    at_a, at_b = at_a[order], at_b[order]
    turn = (place[0][at_a][:, :, None] == place[1][at_b][:, None, :]).argmax(axis=2)
    a, b = nodes[0][at_a], np.take_along_axis(nodes[1][at_b], turn, axis=1)
    apart = a != b
    found, pair = np.unique(np.stack([a[apart], b[apart]], axis=1), axis=0, return_inverse=True)
    facets = np.full(a.shape, -1)
    facets[apart] = pair.ravel()
    vectors = np.repeat(area_vectors(mesh.points, a[:, :3]), apart.sum(axis=1), axis=0)
    normal = np.zeros((len(found), 3))
    np.add.at(normal, facets[apart], vectors)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return LipPairs(found, normal, np.stack([faces[0][at_a], faces[1][at_b]]), facets, turn)


def _places(points: np.ndarray, nodes: list[np.ndarray]) -> list[np.ndarray]:
    """Return numbers of the places of nodes, the same for nodes in one place."""
    flat = np.concatenate([own.ravel() for own in nodes])
    _, place = np.unique(points[flat], axis=0, return_inverse=True)
    parts = np.split(place.ravel(), [nodes[0].size])
    return [part.reshape(own.shape) for part, own in zip(parts, nodes)]
