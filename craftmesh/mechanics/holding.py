"""What holds the bodies of a mesh against moving as a whole: rigid motions, and supports they lack."""

from collections.abc import Sequence

import numpy as np

from craftmesh.mesh.bodies import bodies
from craftmesh.types import TetMesh

# Condition of the rigid motions at the supports. A plane of a hundred thousand nodes and one node more, a
# thousandth of the box away, give some 1e6; a body that is not held gives 1e15 or more.
LOOSE = 1e9


def rigid_motions(points: np.ndarray) -> np.ndarray:
    """Return the displacements (n, 3, 6) of three shifts and of three small turns about the middle."""
    x, y, z = (points - points.mean(axis=0)).T
    motions = np.zeros((len(points), 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 0, 4], motions[:, 2, 4] = z, -x
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions


def lacking(mesh: TetMesh, held: Sequence[tuple[np.ndarray, int]]) -> list[tuple[int, int]]:
    """Return nodes and axes (0, 1, 2) that hold what `held`, nodes (k,) and axis each, leaves free to move.

    A body (elements joined by nodes) gets one at a time the displacement that its free motions move most,
    until no rigid motion of it is free.
    """
    body = bodies(mesh)
    found = []
    for one in range(body.max() + 1):
        nodes = np.unique(mesh.tets[body == one, :4])
        places = mesh.points[nodes]
        motions = rigid_motions(places / np.ptp(places, axis=0).max())
        rows = np.concatenate([motions[np.isin(nodes, supported), axis] for supported, axis in held])
        while len(free := _free(rows)):
            node, axis = divmod(int(np.argmax(((motions @ free.T) ** 2).sum(axis=2))), 3)
            found.append((int(nodes[node]), axis))
            rows = np.concatenate([rows, motions[node, axis][None]])
    return found


def _free(rows: np.ndarray) -> np.ndarray:
    """Return the rigid motions (f, 6) that supports with these rows (k, 6) leave free."""
    padded = np.concatenate([rows, np.zeros((6, 6))])
    _, size, ways = np.linalg.svd(padded, full_matrices=False)
    return ways[size * LOOSE <= max(size[0], 1.0)]
