"""Conversion of 4-node to 10-node tetrahedra, and quarter points."""

from dataclasses import replace

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.front import mesh_fronts
from craftmesh.mesh.integration import smallest_jacobians
from craftmesh.mesh.mesh_sets import node_sets_of
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, OFF_EDGE, group_edges, tet_edges, told_apart
from craftmesh.surface.connectivity import joined
from craftmesh.types import TetMesh


def as_elements(mesh: TetMesh, element: str, quarter_points: bool = False) -> tuple[TetMesh, dict]:
    """Return `mesh` with the nodes of `element`, C3D4 or C3D10, and a report of names and counts.

    4-node meshes become 10-node meshes for C3D10, with quarter points at the crack front if asked for (see
    `move_to_quarter_points`). Raises CraftmeshError if a 10-node mesh should become C3D4, or if 4-node
    elements should have quarter points.
    """
    if element == "C3D10" and mesh.tets.shape[1] == 4:
        mesh = raise_order(mesh)
    if mesh.tets.shape[1] != int(element[3:]):
        raise CraftmeshError(
            f"element is {element}, but the mesh has {mesh.tets.shape[1]}-node tetrahedra; use C3D10"
        )
    report = {"element": element, "nodes": len(mesh.points), "elements": len(mesh.tets)}
    if not quarter_points:
        return mesh, report
    if element != "C3D10":
        raise CraftmeshError(f"quarter_points: {element} has no mid nodes; use C3D10, or no quarter points")
    mesh, counts = move_to_quarter_points(mesh)
    return mesh, report | counts


def raise_order(mesh: TetMesh) -> TetMesh:
    """Return `mesh` with a shared mid node on each edge, in Abaqus' order 12 23 31 14 24 34.

    Corner nodes keep their ids. Mid nodes join the sets of the box, of the lips and of the fronts (between
    their corners); other node sets stay as they are. An edge across the crack whose ends are both on the
    front gets one mid node per lip. Raises CraftmeshError if the mesh already has 10-node elements.
    """
    if mesh.tets.shape[1] != 4:
        raise CraftmeshError("the mesh already has 10-node tetrahedra; expected 4-node ones")
    groups = group_edges(tet_edges(mesh.tets))
    mid = _open_chords(mesh, groups.index.reshape(-1, 6), len(groups.lead))
    lead = np.empty(mid.max(initial=-1) + 1, np.int64)
    lead[mid.ravel()[::-1]] = np.arange(mid.size)[::-1]
    ends = mesh.points[mesh.tets[lead[:, None] // 6, EDGE_CORNERS[lead % 6]]]
    points = np.concatenate([mesh.points, 0.5 * (ends[:, 0] + ends[:, 1])])
    tets = np.hstack([mesh.tets, len(mesh.points) + mid])
    raised = replace(mesh, points=points, tets=tets)
    sets = dict(mesh.node_sets) | node_sets_of(tets, mesh.face_sets, mesh_fronts(raised))
    return replace(raised, node_sets=sets)


def _open_chords(mesh: TetMesh, edge: np.ndarray, count: int) -> np.ndarray:
    """Return `edge` (m, 6), the numbers of the elements' edges, with edges between two front nodes split.

    Elements around an edge between two front nodes are connected if they share a face at it. The first
    component keeps the edge's number, and others, as on the second lip, get numbers from `count` on.
    """
    on_front = np.zeros(len(mesh.points), bool)
    on_front[mesh.node_sets.get("CRACK_FRONT", [])] = True
    tet, local = np.nonzero(on_front[mesh.tets][:, EDGE_CORNERS].all(axis=2))
    if not len(tet):
        return edge
    third = mesh.tets[tet[:, None], OFF_EDGE[local]]
    number = edge[tet, local]
    _, face = np.unique(number[:, None] * len(mesh.points) + third, return_inverse=True)
    rows = np.repeat(np.arange(len(tet)), 2)
    which = joined(len(tet) + face.max() + 1, rows, len(tet) + face.ravel())[: len(tet)]
    edge = edge.copy()
    edge[tet, local], _ = told_apart(number, which, count)
    return edge


def move_to_quarter_points(mesh: TetMesh) -> tuple[TetMesh, dict]:
    """Move mid nodes of edges with one end on CRACK_FRONT to a quarter of the edge from that end.

    Displacements in such elements grow with the square root of the distance to the front, as near a crack
    (Henshell & Shaw 1975; Barsoum 1976). Mid nodes of front edges and of edges between two front nodes, and
    all other nodes, stay. A mid node and its twin on the other lip also stay if moving them would give an
    element at either a Jacobian <= 0 at an integration point. mesh: 10-node tetrahedra. Returns the mesh
    and the counts `quarter_points` and `quarter_points_refused`.
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
    return replace(mesh, points=points), {
        "quarter_points": int((~refused).sum()),
        "quarter_points_refused": int(refused.sum()),
    }


def _front_edges(mesh: TetMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mid nodes, front ends and other ends (k,) of the edges that have only one end on the front."""
    on_front = np.zeros(len(mesh.points), bool)
    on_front[mesh.node_sets.get("CRACK_FRONT", [])] = True
    tets = mesh.tets[on_front[mesh.tets].any(axis=1)]
    ends = tets[:, EDGE_CORNERS]
    tet, edge = np.nonzero(on_front[ends].sum(axis=2) == 1)
    mid, first = np.unique(tets[tet, 4 + edge], return_index=True)
    a, b = ends[tet[first], edge[first]].T
    return mid, np.where(on_front[a], a, b), np.where(on_front[a], b, a)
