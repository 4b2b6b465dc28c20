"""The front of an opened crack: its ordered nodes."""

from collections.abc import Iterator, Mapping

import numpy as np

from craftmesh.mesh.mesh_sets import is_lip, lip_faces
from craftmesh.mesh.tet_connectivity import face_nodes, group_edges
from craftmesh.surface.connectivity import facet_edges
from craftmesh.types import TetMesh


def front_polylines(
    points: np.ndarray, tets: np.ndarray, face_sets: Mapping[str, np.ndarray]
) -> list[tuple[np.ndarray, bool]]:
    """Return the crack's fronts as (ordered corner nodes, closed?), sorted by their first nodes' positions.

    A front edge lies on the rim of lip A and on no other free face. Lip B has the same two nodes, on a
    facet that coincides with lip A's facet there. Where a crack branches, lips of two branches share edges
    too, but no facets. A front runs so that the crack is on its left as seen from lip A. A closed front
    starts at its point of lowest x, then y, then z, which is not repeated. A front through a node where
    front edges branch is cut there.
    """
    return sorted(
        _chains(_front_edges(points, tets[:, :4], face_sets), points),
        key=lambda chain: tuple(points[chain[0][0]]),
    )


def mesh_fronts(mesh: TetMesh) -> list[tuple[np.ndarray, bool]]:
    """Return the fronts of a mesh as (ordered nodes, closed?); mid nodes, if any, stand between corners."""
    fronts = front_polylines(mesh.points, mesh.tets, mesh.face_sets)
    if mesh.tets.shape[1] == 4:
        return fronts
    nodes = face_nodes(mesh.tets, lip_faces(mesh.face_sets)[0])
    mid_of = {(a, b): mid for i in range(3) for a, b, mid in nodes[:, [i, (i + 1) % 3, 3 + i]].tolist()}
    found = []
    for corners, closed in fronts:
        ahead = np.roll(corners, -1) if closed else corners[1:]
        mids = [mid_of[edge] for edge in zip(corners.tolist(), ahead.tolist())]
        both = np.empty(len(corners) + len(mids), np.int64)
        both[0::2], both[1::2] = corners, mids
        found.append((both, closed))
    return found


def _front_edges(points: np.ndarray, tets: np.ndarray, face_sets: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the directed front edges (k, 2), as `front_polylines` defines them."""
    lips = [face_nodes(tets, faces) for faces in lip_faces(face_sets)]
    if not all(map(len, lips)):
        return np.zeros((0, 2), np.int64)
    on_a, on_b = np.zeros(len(points), bool), np.zeros(len(points), bool)
    on_a[lips[0]] = on_b[lips[1]] = True
    shared = on_a & on_b
    other_faces = [
        face_nodes(tets, faces) for name, faces in face_sets.items() if len(faces) and not is_lip(name)
    ]
    edges = [facet_edges(triangles) for triangles in (lips[0], *other_faces)]
    kept = [np.flatnonzero(shared[rows].all(axis=1)) for rows in edges]
    together = np.concatenate([rows[chosen] for rows, chosen in zip(edges, kept)])
    groups = group_edges(together)
    once = groups.lead[groups.count == 1]
    once = np.sort(once[once < len(kept[0])])
    return together[once][_have_twins(points, lips[0][kept[0][once] // 3], lips[1], together[once])]


def _have_twins(
    points: np.ndarray, triangles: np.ndarray, others: np.ndarray, edges: np.ndarray
) -> np.ndarray:
    """Return a mask of edges (k, 2) whose triangle (k, 3) has a twin among `others` (j, 3).

    The twin has the edge's nodes and its third corner at the same position.
    """
    theirs = facet_edges(others)
    near = np.isin(theirs, edges).all(axis=1)
    ends = np.sort(np.concatenate([edges, theirs[near]]), axis=1)
    corners = np.concatenate([triangles, np.repeat(others, 3, axis=0)[near]])
    third = corners.sum(axis=1) - ends.sum(axis=1)
    _, place = np.unique(points[third], axis=0, return_inverse=True)
    _, row = np.unique(np.column_stack([ends, place.ravel()]), axis=0, return_inverse=True)
    return np.isin(row.ravel()[: len(edges)], row.ravel()[len(edges) :])


def _chains(edges: np.ndarray, points: np.ndarray) -> Iterator[tuple[np.ndarray, bool]]:
    """Yield (nodes, closed?) of chains of directed edges, cut at nodes without one edge in and one out."""
    ahead: dict[int, list[int]] = {}
    behind: dict[int, int] = {}
    for tail, head in edges.tolist():
        ahead.setdefault(tail, []).append(head)
        behind[head] = behind.get(head, 0) + 1
    joints = {node for node in ahead.keys() | behind.keys() if len(ahead.get(node, ())) != 1}
    joints |= {node for node in ahead if behind.get(node, 0) != 1}
    for start in sorted(joints & ahead.keys()):
        for node in ahead.pop(start):
            chain = [start, node]
            while node not in joints:
                node = ahead.pop(node)[0]
                chain.append(node)
            closed = chain[0] == chain[-1]
            yield np.array(chain[:-1] if closed else chain, np.int64), closed
    for start in sorted(ahead, key=lambda node: tuple(points[node])):
        chain = []
        while start in ahead:
            chain.append(start)
            start = ahead.pop(start)[0]
        if chain:
            yield np.array(chain, np.int64), True
