"""Rigid motions of the bodies of a mesh, and the supports that these bodies lack."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.tet_connectivity import bodies
from craftmesh.surface.connectivity import compact
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import TetMesh

# Condition number of the rigid motions at the supports above which a body is free. A plane of 1e5 nodes and
# one more node, a thousandth of the box away, give about 1e6; a body that is not held gives 1e15 or more.
LOOSE = 1e9


def rigid_motions(points: np.ndarray, middle: np.ndarray | None = None) -> np.ndarray:
    """Return displacements (n, 3, 6) of points (n, 3) in three unit shifts and three rotations.

    middle (3,): the centre of the rotations, whose angles are 1 radian (linearized); None: mean point.
    """
    x, y, z = (points - (points.mean(axis=0) if middle is None else middle)).T
    motions = np.zeros((len(points), 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 0, 4], motions[:, 2, 4] = z, -x
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions


class Body(NamedTuple):
    """A body of a mesh: elements that common nodes connect.

    elements (m,): mask of its elements; nodes (n,): ids of their corners; size: its largest extent; motions
    (n, 3, 6): displacements of the nodes in the six rigid motions, with lengths relative to size; rows
    (k, 6): these displacements in the components that supports keep at 0.
    """

    elements: np.ndarray
    nodes: np.ndarray
    size: float
    motions: np.ndarray
    rows: np.ndarray


def supported_bodies(mesh: TetMesh, held: Sequence[tuple[np.ndarray, int]]) -> Iterator[Body]:
    """Yield the bodies of a mesh.

    held: nodes (k,) and axis (0, 1, 2) of each support; held nodes that are no corners do not count.
    """
    body = bodies(mesh)
    for one in range(body.max(initial=-1) + 1):
        nodes = compact(mesh.points, mesh.tets[body == one, :4])[2]
        places = mesh.points[nodes]
        size = np.ptp(places, axis=0).max()
        motions = rigid_motions(places / size)
        parts = (motions[np.isin(nodes, supported), axis] for supported, axis in held)
        yield Body(body == one, nodes, size, motions, np.concatenate([np.zeros((0, 6)), *parts]))


def lacking(
    mesh: TetMesh, held: Sequence[tuple[np.ndarray, int]], forces: np.ndarray
) -> list[tuple[int, int]]:
    """Return pairs (node, axis) that must be held in addition to `held`, so that no body can move freely.

    held: nodes (k,) and axis of each support. In each body, the displacement component that its free rigid
    motions move most is held, one after the other, until no rigid motion is free. Raises CraftmeshError if
    the forces (n, 3) at the nodes would drive a free motion.
    """
    found = []
    for body in supported_bodies(mesh, held):
        rows = body.rows
        while len(free := free_motions(rows)):
            _check_balance(mesh, body.elements, free, forces, body.size)
            node, axis = divmod(int(np.argmax(((body.motions @ free.T) ** 2).sum(axis=2))), 3)
            found.append((int(body.nodes[node]), axis))
            rows = np.concatenate([rows, body.motions[node, axis][None]])
    return found


def _check_balance(
    mesh: TetMesh, of_body: np.ndarray, free: np.ndarray, forces: np.ndarray, size: float
) -> None:
    """Raise CraftmeshError if forces (n, 3) at the nodes do work in free motions (f, 6) of a body.

    of_body (m,): mask of the body's elements; size: its largest extent, the unit of length of the motions.
    """
    nodes = np.unique(mesh.tets[of_body])
    own = forces[nodes]
    middle = mesh.points[np.unique(mesh.tets[of_body, :4])].mean(axis=0)
    motions = rigid_motions(mesh.points[nodes] / size, middle / size)
    left = np.einsum("nai,na->i", motions, own) @ free.T @ free
    if np.abs(left).max() <= ROUNDING * np.abs(own).sum():
        return
    way = int(np.argmax(np.abs(left)))
    axis, is_turn = "xyz"[way % 3], way > 2
    kind, value = ("moment", left[way] * size) if is_turn else ("force", left[way])
    where = "the body"
    if not of_body.all():
        at = ", ".join(f"{x:.4g}" for x in middle)
        where = f"the separate piece of {of_body.sum()} elements around ({at}), as a crack may cut off"
    raise CraftmeshError(
        f"load: the stresses leave a {kind} of {value:.4g} {'about' if is_turn else 'along'} {axis} on "
        f"{where}, and no support resists it; prescribe a displacement of a face there, or "
        "stresses that balance"
    )


def free_motions(rows: np.ndarray) -> np.ndarray:
    """Return the rigid motions (f, 6), weights of the six basic ones, that supports leave free.

    rows (k, 6): displacement of each supported component in the six motions. A motion is free if it moves
    the supports less than 1 / LOOSE of the motion that moves them most.
    """
    padded = np.concatenate([rows, np.zeros((6, 6))])
    _, size, ways = np.linalg.svd(padded, full_matrices=False)
    return ways[size * LOOSE <= max(size[0], 1.0)]
