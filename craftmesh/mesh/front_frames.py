"""The front of an opened crack node by node: frames, grains, ends, sizes."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mesh.front import mesh_fronts
from craftmesh.mesh.front_curve import FrontCurve, arc_lengths, front_curve, local_sizes
from craftmesh.mesh.front_places import faces_of_nodes, grain_of_edges, meets_boundary
from craftmesh.mesh.lip_normals import front_normals
from craftmesh.types import TetMesh

NONE = -1


@dataclass(frozen=True, eq=False)
class FrontFrames:
    """One row per front node at a corner, in order; several fronts follow one another.

    s (k,) arc length from the front's first node; points, tangent, normal, binormal (k, 3): tangents of a
    smooth curve along the nodes; normal is the crack's at its front, from lip B to lip A; binormal =
    tangent x normal points out of the crack, into the material that it has not reached. front (k,) number
    of the front from 1; closed (k,) 1 on closed fronts; node (k,) id from 0; mid_node (k,) id of the mid
    node of the edge that follows, -1 where the mesh has none or no edge follows; grain (k,) along that
    edge, at an open end that of the edge before; pierce (k,) 1 where grains meet in the node; end (k,) 1 at
    open ends; face (k,) the faces on which such an end lies, empty elsewhere; size (k,) the mean length of
    the front's edges nearby.
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

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of front.csv in order; nodes are numbered from 1 as in the deck, 0 is none."""
        columns = {name: getattr(self, name) for name in type(self).__dataclass_fields__}
        return columns | {"node": self.node + 1, "mid_node": self.mid_node + 1}


@dataclass(frozen=True, eq=False)
class Front:
    """One front: its corner nodes (k,) in order, the mid nodes after them, and the curve along them.

    mids has k entries on a closed front, k - 1 on an open one, none in a mesh without mid nodes.
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
    """Return a row for each front node of `mesh` that is a corner; empty without crack."""
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
    mid = np.full(count, NONE)
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
