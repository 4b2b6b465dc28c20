"""Where a front runs: the grain along each edge, grain boundaries that it meets, faces at its ends."""

import numpy as np

from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, face_nodes
from craftmesh.types import BOX_PLANES, TetMesh

_FACES_AT_EDGE = np.array([[2, 3], [0, 3], [1, 3], [1, 2], [0, 2], [0, 1]])  # the corners off each edge


def grain_of_edges(mesh: TetMesh, tails: np.ndarray, heads: np.ndarray) -> np.ndarray:
    """Return the grain (k,) that fills most of the angle round each edge from tails (k,) to heads (k,)."""
    edge, tet, local = _round_edges(mesh, tails, heads)
    ids, grain = np.unique(mesh.grain[tet], return_inverse=True)
    angle = np.zeros((len(tails), len(ids)))
    np.add.at(angle, (edge, grain.ravel()), _dihedral(mesh, tet, local))
    return ids[np.argmax(np.round(angle, 9), axis=1)]  # equal angles: the lower id


def edges_between_materials(
    mesh: TetMesh, tails: np.ndarray, heads: np.ndarray, material: np.ndarray
) -> np.ndarray:
    """Return which edges (k,) have elements of several materials (m,), numbers by element, round them."""
    edge, tet, _ = _round_edges(mesh, tails, heads)
    first = np.zeros(len(tails), np.int64)
    first[edge] = material[tet]
    several = np.zeros(len(tails), bool)
    several[edge[material[tet] != first[edge]]] = True
    return several


def _round_edges(
    mesh: TetMesh, tails: np.ndarray, heads: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each pair of an edge and an element at it: their rows, and the number of its own edge."""
    wanted = _keys(tails, heads, len(mesh.points))
    order = np.argsort(wanted)
    at_front = np.zeros(len(mesh.points), bool)
    at_front[tails] = at_front[heads] = True
    rows = np.flatnonzero(at_front[mesh.tets[:, :4]].sum(axis=1) > 1)
    ends = mesh.tets[rows][:, EDGE_CORNERS]
    keys = _keys(ends[..., 0], ends[..., 1], len(mesh.points))
    place = np.minimum(np.searchsorted(wanted[order], keys), len(order) - 1)
    tet, local = np.nonzero(wanted[order][place] == keys)
    return order[place[tet, local]], rows[tet], local


def meets_boundary(mesh: TetMesh, nodes: np.ndarray) -> np.ndarray:
    """Return which front nodes (k,) have elements of several grains round them."""
    at_front = np.zeros(len(mesh.points), bool)
    at_front[nodes] = True
    rows = np.flatnonzero(at_front[mesh.tets[:, :4]].any(axis=1))
    corners, grain = mesh.tets[rows, :4], mesh.grain[rows]
    low = np.full(len(mesh.points), np.iinfo(np.int32).max)
    high = np.full(len(mesh.points), np.iinfo(np.int32).min)
    np.minimum.at(low, corners, grain[:, None])
    np.maximum.at(high, corners, grain[:, None])
    return low[nodes] < high[nodes]


def faces_of_nodes(mesh: TetMesh, nodes: np.ndarray) -> list[str]:
    """Return the free faces that hold each end of a front: XMIN, XMIN_YMIN, VOID_<k>, EXTERIOR.

    CRACK where there is none of them: the front ends on another crack.
    """
    others = [name for name in mesh.face_sets if name not in BOX_PLANES and not is_lip(name)]
    names = [name for name in (*BOX_PLANES, *others) if name in mesh.face_sets]
    on_face = {name: np.isin(nodes, face_nodes(mesh.tets, mesh.face_sets[name])) for name in names}
    found = ["_".join(name for name in names if on_face[name][k]) for k in range(len(nodes))]
    return [name or "CRACK" for name in found]


def _keys(tails: np.ndarray, heads: np.ndarray, stride: int) -> np.ndarray:
    return np.minimum(tails, heads) * stride + np.maximum(tails, heads)


def _dihedral(mesh: TetMesh, tets: np.ndarray, local: np.ndarray) -> np.ndarray:
    """Return the angles (k,) in radians between the two faces at edge `local` (k,) of tets (k,)."""
    nodes = mesh.tets[tets]
    a, b = (mesh.points[np.take_along_axis(nodes, EDGE_CORNERS[local, i, None], 1)[:, 0]] for i in range(2))
    off = [np.take_along_axis(nodes, _FACES_AT_EDGE[local, i, None], 1)[:, 0] for i in range(2)]
    u, v = (np.cross(b - a, mesh.points[node] - a) for node in off)
    return np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1))
