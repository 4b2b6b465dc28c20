"""The front of an opened crack node by node: frames, grains, ends and local sizes."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mesh.front import mesh_fronts
from craftmesh.mesh.front_curve import FrontCurve, arc_lengths, front_curve, local_sizes
from craftmesh.mesh.lips import front_normals
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, OFF_EDGE, dihedral_angles, face_nodes
from craftmesh.types import BOX_PLANES, TetMesh


def grain_of_edges(mesh: TetMesh, tails: np.ndarray, heads: np.ndarray) -> np.ndarray:
    """Return the grain (k,) that fills most of the angle around each edge from tails (k,) to heads (k,)."""
    edge, tet, local = _round_edges(mesh, tails, heads)
    ids, grain = np.unique(mesh.grain[tet], return_inverse=True)
    angle = np.zeros((len(tails), len(ids)))
    row, nodes = np.arange(len(tet)), mesh.tets[tet]
    ends = (nodes[row, table[local, k]] for table in (EDGE_CORNERS, OFF_EDGE) for k in (0, 1))
    np.add.at(angle, (edge, grain.ravel()), dihedral_angles(mesh.points, *ends))
    return ids[np.argmax(np.round(angle, 9), axis=1)]  # the lower id if angles are equal


def edges_between_materials(
    mesh: TetMesh, tails: np.ndarray, heads: np.ndarray, material: np.ndarray
) -> np.ndarray:
    """Return a mask (k,) of edges from tails to heads (k,) that elements of several materials surround.

    material (m,): number of each element's material.
    """
    edge, tet, _ = _round_edges(mesh, tails, heads)
    first = np.zeros(len(tails), np.int64)
    first[edge] = material[tet]
    several = np.zeros(len(tails), bool)
    several[edge[material[tet] != first[edge]]] = True
    return several


def _round_edges(
    mesh: TetMesh, tails: np.ndarray, heads: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return all pairs (p,) of an edge and an element that has it.

    Returns the row of the edge, the row of the element, and the edge's number 0..5 in the element.
    """
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
    """Return a mask (k,) of front nodes whose elements belong to several grains."""
    at_front = np.zeros(len(mesh.points), bool)
    at_front[nodes] = True
    rows = np.flatnonzero(at_front[mesh.tets[:, :4]].any(axis=1))
    pairs = np.column_stack([mesh.tets[rows, :4].ravel(), np.repeat(mesh.grain[rows], 4)])
    found, grains = np.unique(np.unique(pairs, axis=0)[:, 0], return_counts=True)
    return np.isin(nodes, found[grains > 1])


def faces_of_nodes(mesh: TetMesh, nodes: np.ndarray) -> list[str]:
    """Return for each front end the names of its free faces, joined by _: XMIN, XMIN_YMIN, VOID_<k>.

    CRACK if an end lies on none of them: the front ends on another crack.
    """
    others = [name for name in mesh.face_sets if name not in BOX_PLANES and not is_lip(name)]
    names = [name for name in (*BOX_PLANES, *others) if name in mesh.face_sets]
    on_face = {name: np.isin(nodes, face_nodes(mesh.tets, mesh.face_sets[name])) for name in names}
    found = ["_".join(name for name in names if on_face[name][k]) for k in range(len(nodes))]
    return [name or "CRACK" for name in found]


def _keys(tails: np.ndarray, heads: np.ndarray, stride: int) -> np.ndarray:
    return np.minimum(tails, heads) * stride + np.maximum(tails, heads)


@dataclass(frozen=True, eq=False)
class FrontFrames:
    """One row per front node that is an element corner, in order; several fronts follow one another.

    s (k,): arc length from the front's first node; points, tangent, normal, binormal (k, 3): tangents of a
    smooth curve along the nodes; normal of the crack at its front, from lip B to lip A; binormal = tangent
    x normal points out of the crack, into the material that it has not reached. front (k,): number of the
    front, from 1; closed (k,): 1 on closed fronts; node (k,): id, from 0; mid_node (k,): id of the next
    edge's mid node, -1 if the mesh has none or no edge follows; grain (k,): along the next edge, at an open
    end along the edge before; pierce (k,): 1 where grains meet at the node; end (k,): 1 at open ends; face
    (k,): the faces on which such an end lies, empty elsewhere; size (k,): mean length of the front's edges
    nearby.
    """

    s: np.ndarray
    points: np.ndarray
    tangent: np.ndarray
    normal: np.ndarray
    binormal: np.ndarray
    front: np.ndarray
    closed: np.ndarray
    node: np.ndarray
    mid_node: np.ndarray
    grain: np.ndarray
    pierce: np.ndarray
    end: np.ndarray
    face: np.ndarray
    size: np.ndarray

    @property
    def axes(self) -> np.ndarray:
        """(k, 3, 3) local axes of each node: rows binormal, normal and tangent."""
        return np.stack([self.binormal, self.normal, self.tangent], axis=1)

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of front.csv by name, in order; node numbers start at 1, as in the deck.

        A missing mid node is 0.
        """
        columns = {name: getattr(self, name) for name in type(self).__dataclass_fields__}
        return columns | {"node": self.node + 1, "mid_node": self.mid_node + 1}


@dataclass(frozen=True, eq=False)
class Front:
    """One front: its corner nodes (k,) in order, the mid nodes after them, and the curve along them.

    mids has k entries on a closed front, k - 1 on an open front, and none in a mesh without mid nodes.
    """

    corners: np.ndarray
    mids: np.ndarray
    closed: bool
    curve: FrontCurve


def fronts_of(mesh: TetMesh) -> list[Front]:
    """Return the fronts of a mesh as `mesh_fronts` orders them, with their curves."""
    step = 1 if mesh.tets.shape[1] == 4 else 2
    found = []
    for nodes, closed in mesh_fronts(mesh):
        corners = nodes[::step]
        points, sizes = mesh.points[corners], local_sizes(mesh.points[corners], closed)
        _, tangents, _, _ = front_curve(points, np.zeros(points.shape), closed).frames(
            arc_lengths(points, closed)[0]
        )
        normals = front_normals(mesh, corners, tangents, sizes)
        mids = nodes[1::2] if step == 2 else np.zeros(0, np.int64)
        found.append(Front(corners, mids, closed, front_curve(points, normals, closed)))
    return found


def front_frames(mesh: TetMesh) -> FrontFrames:
    """Return a row for each front node of `mesh` that is an element corner; no rows without a crack."""
    parts = [_rows(mesh, number, front) for number, front in enumerate(fronts_of(mesh), 1)]
    if parts:
        return FrontFrames(*map(np.concatenate, zip(*parts)))
    none, vectors, numbers = np.zeros(0), np.zeros((0, 3)), np.zeros(0, np.int64)
    return FrontFrames(none, *(vectors,) * 4, *(numbers,) * 7, np.zeros(0, str), none)


def _rows(mesh: TetMesh, number: int, front: Front) -> tuple[np.ndarray, ...]:
    """Return the columns of FrontFrames for one front."""
    corners, closed, count = front.corners, front.closed, len(front.corners)
    s, _ = arc_lengths(mesh.points[corners], closed)
    _, tangent, normal, binormal = front.curve.frames(s)
    mid = np.full(count, -1)
    mid[: len(front.mids)] = front.mids
    edges = count if closed else count - 1
    grain = grain_of_edges(mesh, corners[:edges], np.roll(corners, -1)[:edges])
    grain = grain if closed else np.append(grain, grain[-1])
    end, face = np.zeros(count, np.int64), np.full(count, "", object)
    if not closed:
        end[[0, -1]] = 1
        face[[0, -1]] = faces_of_nodes(mesh, corners[[0, -1]])
    return (
        s, mesh.points[corners], tangent, normal, binormal, np.full(count, number),
        np.full(count, int(closed)), corners, mid, grain, meets_boundary(mesh, corners).astype(np.int64),
        end, face, local_sizes(mesh.points[corners], closed),
    )  # fmt: skip
