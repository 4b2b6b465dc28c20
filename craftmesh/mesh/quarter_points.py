"""Quarter-point elements around the crack front."""

import numpy as np

from craftmesh.mesh.kernels.tet_jacobians import smallest_jacobians
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS
from craftmesh.types import TetMesh


def move_to_quarter_points(mesh: TetMesh) -> tuple[TetMesh, dict]:
    """Move mid nodes of edges with one end on CRACK_FRONT to a quarter of the edge from that end.

    The displacements of such elements grow with the square root of the distance to the front, as those
    at a crack do (Henshell & Shaw 1975; Barsoum 1976). Front edges, edges between two front nodes and
    all other nodes keep their places. A mid node stays where it is, and so does its twin on the other
    lip, when an element at either would get a Jacobian <= 0 at an integration point. mesh: 10-node
    tetrahedra. Return the mesh and the counts `quarter_points` and `quarter_points_refused`.
    """
    mid, front, other = _front_edges(mesh)
    points = mesh.points.copy()
    points[mid] = points[front] + 0.25 * (points[other] - points[front])  # exact on box planes
    at_front = np.zeros(len(points), bool)
    at_front[mid] = True
    tets = mesh.tets[at_front[mesh.tets].any(axis=1)]
    _, place = np.unique(mesh.points[mid], axis=0, return_inverse=True)  # twins on the lips have one place
    place = place.ravel()
    refused = np.zeros(len(mid), bool)
    while True:
        bad = np.isin(mid, tets[smallest_jacobians(points, tets) <= 0]) & ~refused
        if not bad.any():
            break
        refused |= np.isin(place, place[bad])
        points[mid[refused]] = mesh.points[mid[refused]]
    moved = TetMesh(points, mesh.tets, mesh.grain, mesh.node_sets, mesh.face_sets)
    return moved, {
        "quarter_points": int((~refused).sum()),
        "quarter_points_refused": int(refused.sum()),
    }


def _front_edges(mesh: TetMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mid node, end on the front and other end of the edges with exactly one end on the front."""
    on_front = np.zeros(len(mesh.points), bool)
    on_front[mesh.node_sets.get("CRACK_FRONT", [])] = True
    tets = mesh.tets[on_front[mesh.tets].any(axis=1)]
    ends = tets[:, EDGE_CORNERS]
    tet, edge = np.nonzero(on_front[ends].sum(axis=2) == 1)
    mid, first = np.unique(tets[tet, 4 + edge], return_index=True)
    a, b = ends[tet[first], edge[first]].T
    return mid, np.where(on_front[a], a, b), np.where(on_front[a], b, a)
