"""Which displacements a load prescribes, and that they hold the body."""

from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.holding import LOOSE, rigid_motions
from craftmesh.mechanics.load import Load
from craftmesh.mesh.bodies import bodies
from craftmesh.types import TetMesh


@dataclass(frozen=True, eq=False)
class Supports:
    """fixed (n, 3) bool: prescribed components; displacement (n, 3): their values, 0 elsewhere."""

    fixed: np.ndarray
    displacement: np.ndarray


def supports_of(load: Load, mesh: TetMesh) -> Supports:
    """Return the supports of a load; nodes without an element are held too.

    Raises CraftmeshError where two values are prescribed for one displacement, and where a piece of the
    body can move as a whole.
    """
    fixed = np.zeros(mesh.points.shape, bool)
    displacement = np.zeros(mesh.points.shape)
    for part in (*load.held, *load.moved):
        before = displacement[part.nodes, part.axis]
        clash = fixed[part.nodes, part.axis] & (before != part.displacement)
        if clash.any():
            raise CraftmeshError(
                f"load: node {part.nodes[clash][0] + 1} is to move along {'xyz'[part.axis]} by "
                f"{before[clash][0]:g} and by another value too; prescribe one"
            )
        fixed[part.nodes, part.axis] = True
        displacement[part.nodes, part.axis] = part.displacement
    _check_held(mesh, fixed)
    idle = np.ones(len(fixed), bool)
    idle[mesh.tets] = False
    fixed[idle] = True
    return Supports(fixed, displacement)


def _check_held(mesh: TetMesh, fixed: np.ndarray) -> None:
    """Refuse a piece of the body (elements joined by nodes) that the supports leave a rigid motion."""
    in_piece = bodies(mesh)
    piece = np.full(len(mesh.points), -1)
    piece[mesh.tets] = in_piece[:, None]
    motions = rigid_motions(mesh.points / max(np.ptp(mesh.points, axis=0).max(initial=0.0), 1e-300))
    node, axis = np.nonzero(fixed)
    order = np.argsort(piece[node], kind="stable")
    node, axis = node[order], axis[order]
    for number in np.unique(in_piece):
        low, high = np.searchsorted(piece[node], [number, number + 1])
        rows = motions[node[low:high], axis[low:high]]
        if len(rows) < 6 or np.linalg.cond(rows) > LOOSE:
            elements = np.flatnonzero(in_piece == number)
            place = ", ".join(f"{x:.4g}" for x in mesh.points[mesh.tets[elements[0], 0]])
            raise CraftmeshError(
                f"load: a piece of {len(elements)} elements at ({place}), grain {mesh.grain[elements[0]]}, "
                "is not held against moving as a whole; hold it (sides, axis), or end the growth before "
                "the crack severs the body"
            )
