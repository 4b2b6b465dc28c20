"""Faces and edges of tetrahedra in Abaqus' numbering, and their connections; computed, never stored."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mesh.kernels.row_groups import group_faces, group_rows
from craftmesh.surface.connectivity import in_order, joined
from craftmesh.types import TetMesh

# Corners of faces S1..S4; by the right-hand rule their normals point into an element of positive volume.
FACE_CORNERS = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
# Corners of the edges that carry the mid nodes 5..10.
EDGE_CORNERS = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])
OFF_EDGE = EDGE_CORNERS[[5, 3, 4, 1, 2, 0]]  # for each edge, the two corners that are not on it
# Edges of faces S1..S4, each from one corner to the next.
FACE_EDGES = np.array([[0, 1, 2], [3, 4, 0], [4, 5, 1], [5, 3, 2]])
# Nodes of faces S1..S4 by the element's number of nodes: the corners, then the mid nodes of those edges.
FACE_NODES = {4: FACE_CORNERS, 10: np.hstack([FACE_CORNERS, 4 + FACE_EDGES])}


@dataclass(frozen=True)
class RowGroups:
    """Rows with equal contents: group j holds rows order[first[j] : first[j + 1]], ascending."""

    order: np.ndarray
    first: np.ndarray

    @property
    def count(self) -> np.ndarray:
        """(g,) number of rows per group."""
        return np.diff(self.first)

    @property
    def lead(self) -> np.ndarray:
        """(g,) the lowest row of each group."""
        return self.order[self.first[:-1]]

    @property
    def index(self) -> np.ndarray:
        """(k,) the group of each row."""
        index = np.empty(len(self.order), np.int64)
        index[self.order] = np.repeat(np.arange(len(self.first) - 1), self.count)
        return index

    @property
    def pairs(self) -> np.ndarray:
        """(p, 2) the two rows of the groups that have exactly two."""
        start = self.first[:-1][self.count == 2]
        return np.stack([self.order[start], self.order[start + 1]], axis=1)


def half_faces(tets: np.ndarray) -> np.ndarray:
    """Return the corners (4m, 3) of all faces: row 4 * tet + face."""
    return np.take(tets, FACE_CORNERS.ravel(), axis=1).reshape(-1, 3)


def half_face_corners(tets: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the corners (..., 3) of the half faces `rows` (...) = 4 * tet + face."""
    return tets[(rows // 4)[..., None], FACE_CORNERS[rows % 4]]


def free_half_faces(tets: np.ndarray) -> np.ndarray:
    """Return the half faces (k,), rows 4 * tet + face, that no two tets (m, 4) share, ascending."""
    groups = _group_faces(tets, np.zeros((0, 3), np.int64))
    rows: np.ndarray = np.sort(groups.lead[groups.count == 1])
    return rows


def tet_edges(tets: np.ndarray) -> np.ndarray:
    """Return the end nodes (6m, 2) of all edges: row 6 * tet + edge."""
    return np.take(tets, EDGE_CORNERS.ravel(), axis=1).reshape(-1, 2)


def half_face_nodes(tets: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the nodes (..., 3), or with mid nodes (..., 6), of the half faces `rows` (...)."""
    return tets[(rows // 4)[..., None], FACE_NODES[tets.shape[1]][rows % 4]]


def group_triples(triples: np.ndarray) -> RowGroups:
    """Group triangles (k, 3) that have the same three corners, in any order."""
    return _group_faces(np.zeros((0, 4), np.int64), triples)


def _group_faces(tets: np.ndarray, triples: np.ndarray) -> RowGroups:
    """Group the half faces of tets (m, 4), and triangles (k, 3) in the rows after these, by corners."""
    tets, triples = (np.require(rows, np.int64, ["C", "W"]) for rows in (tets, triples))
    count = max(int(tets.max(initial=-1)), int(triples.max(initial=-1))) + 1
    return RowGroups(*group_faces(tets, FACE_CORNERS, triples, count))


def facet_groups(tets: np.ndarray, facets: np.ndarray) -> tuple[RowGroups, np.ndarray, np.ndarray]:
    """Group the half faces of tets and the facets (k, 3) by their corners; facets' rows come last.

    Returns the groups, the highest facet in each group (g,), below 0 for none, and the number of the
    group's other rows (g,).
    """
    groups = _group_faces(tets[:, :4], facets)
    facet = groups.order[groups.first[1:] - 1] - 4 * len(tets)
    return groups, facet, groups.count - (facet >= 0)


def told_apart(number: np.ndarray, part: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return numbers (k,) that differ between the parts of one number, and the old number of each new one.

    number, part (k,): the number of each item and the part of it that the item belongs to; parts are
    numbered from 0 in the order of their first items. The first part of a number keeps it, the others get
    new numbers from `count` on.
    """
    first = np.unique(part, return_index=True)[1]
    old = number[first]
    order = np.lexsort((first, old))
    extra = order[1:][old[order[1:]] == old[order[:-1]]]
    new = old.copy()
    new[extra] = count + np.arange(len(extra))
    return new[part], old[extra]


def group_edges(edges: np.ndarray) -> RowGroups:
    """Group edges (k, 2) that have the same two ends, in either order."""
    a, b = (np.asarray(edges[:, i], np.int64) for i in range(2))
    stride = int(edges.max()) + 1 if len(edges) else 0
    return RowGroups(*group_rows(np.minimum(a, b), np.maximum(a, b), stride))


def face_nodes(tets: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the nodes of faces (k, 2), rows (tet, face): (k, 3) corners, or (k, 6) with the mid nodes."""
    return tets[faces[:, :1], FACE_NODES[tets.shape[1]][faces[:, 1]]]


def tet_volumes(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Return signed volumes (m,), positive if corners 1, 2, 3 turn right-handed towards corner 4."""
    a, b, c, d = (points[tets[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def grains_at_nodes(tets: np.ndarray, grain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest grain (n,) of the elements at each node.

    n: one more than the last node in `tets`. grain (m,): grains of the elements. Where the two differ,
    grains share the node. At a node without elements the lowest is above the highest.
    """
    count = tets.max() + 1
    lowest, highest = np.full(count, np.iinfo(np.int32).max), np.full(count, -1)
    np.minimum.at(lowest, tets, grain[:, None])
    np.maximum.at(highest, tets, grain[:, None])
    return lowest, highest


def dihedral_angles(
    points: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray
) -> np.ndarray:
    """Return the dihedral angles (k,) in radians between faces a, b, c and a, b, d; nodes (k,) each."""
    u, v = (np.cross(points[b] - points[a], points[node] - points[a]) for node in (c, d))
    return np.arctan2(np.linalg.norm(np.cross(u, v), axis=-1), (u * v).sum(axis=-1))


def bodies(mesh: TetMesh) -> np.ndarray:
    """Return the number (m,) of each element's connected body, from 0 in the order of first elements."""
    tails = np.repeat(mesh.tets[:, 0], mesh.tets.shape[1] - 1)
    heads = mesh.tets[:, 1:].ravel()
    return in_order(joined(len(mesh.points), tails, heads)[mesh.tets[:, 0]])


def severed_sentence(mesh: TetMesh) -> str:
    """Return a sentence on the mesh's bodies, with places of all but the largest; "" if it is one body."""
    body = bodies(mesh)
    if not body.any():
        return ""
    volume = tet_volumes(mesh.points, mesh.tets)
    size = np.bincount(body, volume)
    told = []
    for number in np.argsort(-size, kind="stable")[1:].tolist():
        own = body == number
        places = mesh.points[mesh.tets[own, :4]].mean(axis=1)
        middle = np.average(places, axis=0, weights=volume[own])
        told.append(f"volume {size[number]:.4g} around ({', '.join(f'{x:.4g}' for x in middle)})")
    return (
        f"the mesh is {len(size)} separate bodies, as where the crack severs it; besides the largest: "
        f"{'; '.join(told)}"
    )
