"""The lips (faces) of a crack: pairs of nodes at one point, and the crack's normal at its front."""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.front_curve import square_to, unit
from craftmesh.mesh.integration import smallest_jacobians
from craftmesh.mesh.mesh_sets import lip_faces, own_lips
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.surface.measure import area_vectors
from craftmesh.types import BOX_PLANES, TetMesh


@dataclass(frozen=True, eq=False)
class LipPairs:
    """Pairs of lip nodes: nodes (p, 2) on lip A and on lip B; normal (p, 3): unit, from lip B to lip A.

    faces (2, f, 2): rows (tet, face) of the faces of lip A that coincide with a face of lip B, then of
    those faces of lip B. facets (f, 3 or 6): for each node of lip A's faces, in the order of `face_nodes`,
    the row of its pair; -1 at nodes of the front, which both lips share. turn (f, 3 or 6): the coincident
    node's position among the nodes of lip B's face.
    """

    nodes: np.ndarray
    normal: np.ndarray
    faces: np.ndarray
    facets: np.ndarray
    turn: np.ndarray

    def gaps(self, displacement: np.ndarray) -> np.ndarray:
        """Return the gap (p,) by which a displacement (n, 3) opens each pair, < 0 if lips overlap."""
        return self.split(self.jumps(displacement))[0]

    def jumps(self, displacement: np.ndarray) -> np.ndarray:
        """Return the displacement (p, 3) of each pair's node on lip A, minus that of its node on lip B."""
        a, b = self.nodes.T
        return displacement[a] - displacement[b]

    def split(self, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return components (p,) along the normals, and parts (p, 3) across them, of vectors (p, 3)."""
        return np.einsum("pi,pi->p", self.normal, vectors), square_to(vectors, self.normal)

    def forces(self, push: np.ndarray, shape: tuple) -> np.ndarray:
        """Return nodal forces, of shape (n, 3), where `push` (p, 3) acts on lip A of pairs, -push on B."""
        out = np.zeros(shape)
        np.add.at(out, self.nodes[:, 0], push)
        np.add.at(out, self.nodes[:, 1], -push)
        return out


def lip_pairs(mesh: TetMesh) -> LipPairs:
    """Return the pairs of all cracks of a mesh; lip faces without a coincident partner have no pairs."""
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
    """Return position numbers of nodes, equal for coincident nodes, in arrays shaped as `nodes`."""
    flat = np.concatenate([own.ravel() for own in nodes])
    _, place = np.unique(points[flat], axis=0, return_inverse=True)
    parts = np.split(place.ravel(), [nodes[0].size])
    return [part.reshape(own.shape) for part, own in zip(parts, nodes)]


def lips_apart(mesh: TetMesh, opening: float) -> TetMesh:
    """Return the mesh with nodes of lips that share a point moved by opening / 2, each into its own side.

    opening: in model units. Nodes of the front share no point with another node and stay; nodes in the sets
    of box planes stay on these. Raises CraftmeshError if the move inverts an element.
    """
    faces = np.concatenate(lip_faces(mesh.face_sets))
    nodes = face_nodes(mesh.tets, faces)
    inward = np.zeros(mesh.points.shape)
    np.add.at(inward, nodes, area_vectors(mesh.points, nodes[:, :3])[:, None])
    for number, plane in enumerate(BOX_PLANES):
        inward[mesh.node_sets.get(plane, []), number // 2] = 0.0
    lip = np.unique(nodes)
    _, place, count = np.unique(mesh.points[lip], axis=0, return_inverse=True, return_counts=True)
    shared = lip[count[place.ravel()] > 1]
    points = mesh.points.copy()
    points[shared] += opening / 2 * unit(inward[shared])
    turned = np.count_nonzero(smallest_jacobians(points, mesh.tets) <= 0)
    if turned:
        raise CraftmeshError(
            f"lips moved {opening:.6g} apart invert {turned} elements; give a smaller opening"
        )
    return replace(mesh, points=points)


# Distance, in local sizes (mean lengths of nearby front edges), within which lip nodes are used to fit a
# quadric at a front node; nearer ones count more. WIDE_FIT is used where its quadric deviates by at most
# SMOOTH local sizes (rms) from the nodes, else NARROW_FIT. On a lens of ten edges radius, where the
# deviation is 0.003, normals err by 0.13 degrees (rms) with WIDE_FIT and by 0.25 with NARROW_FIT; of five
# edges radius, where it is 0.008, by 0.3 and 1.0. A kink of 5 degrees two edges behind the front, as growth
# leaves it, also gives 0.008, and would turn normals by 1.5 degrees with WIDE_FIT, by 0.4 with NARROW_FIT.
WIDE_FIT, NARROW_FIT = 5.0, 3.0
SMOOTH = 0.008
# Smallest cosine between the normals of a lip node and of the front; lip nodes below it lie behind a kink.
SAME_SHEET = np.cos(np.radians(25))
# Fewest nodes for a quadric's slope and three curvatures; with fewer, only the facets at the front count.
LEAST_NODES = 6


def front_normals(mesh: TetMesh, nodes: np.ndarray, tangents: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Return unit normals (k, 3) from lip B to lip A at front nodes (k,).

    tangents (k, 3): of the front; sizes (k,): local edge lengths. On a curved crack the mean normal of the
    facets at the front is that of a place half a facet behind it. A quadric through the front node, along
    its tangent, is fitted to the lip's nodes behind it; its slope at the front corrects that mean.
    """
    tets = mesh.tets[:, :4]
    facets = face_nodes(tets, lip_faces(own_lips(mesh.face_sets, tets, nodes))[0])
    normals = np.zeros(mesh.points.shape)
    np.add.at(normals, facets, area_vectors(mesh.points, facets)[:, None, :])
    lip = np.unique(facets)
    lip_points, lip_normals = mesh.points[lip], unit(normals[lip])
    start = unit(square_to(normals[nodes], tangents))
    found = scipy.spatial.KDTree(lip_points).query_ball_point(
        mesh.points[nodes], WIDE_FIT * sizes, return_sorted=True
    )
    result = start.copy()
    for k, near in enumerate(found):
        near = np.array(near)[lip_normals[near] @ start[k] > SAME_SHEET]
        offset = (lip_points[near] - mesh.points[nodes[k]]) / sizes[k]
        binormal = np.cross(tangents[k], start[k])
        x, y, z = (offset @ axis for axis in (binormal, tangents[k], start[k]))
        slope, off = _fitted(x, y, z, WIDE_FIT)
        slope = slope if off <= SMOOTH else _fitted(x, y, z, NARROW_FIT)[0]
        result[k] = start[k] - slope * binormal
    return unit(result)


def _fitted(x: np.ndarray, y: np.ndarray, z: np.ndarray, reach: float) -> tuple[float, float]:
    """Fit a quadric z(x, y) through the origin, level along y there; return dz/dx there and rms deviation.

    x, y, z: points; those within `reach` count. Returns (0, 0) if fewer than LEAST_NODES of them do.
    """
    weight = np.clip(1 - (x * x + y * y + z * z) / reach**2, 0, None)
    if np.count_nonzero(weight) < LEAST_NODES:
        return 0.0, 0.0
    terms = np.stack([x, x * x, x * y, y * y], axis=1) * weight[:, None]
    found = np.linalg.lstsq(terms, z * weight, rcond=1e-6)[0]
    return float(found[0]), float(np.linalg.norm(terms @ found - z * weight) / np.linalg.norm(weight))
