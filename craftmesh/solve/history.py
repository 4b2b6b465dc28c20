"""The nominal strain and stress of faces through a history of the load."""

from collections.abc import Iterable

import numpy as np

from craftmesh.mechanics.load import Load, Traction, nodal_forces
from craftmesh.types import BOX_PLANES, TetMesh


def acting_faces(loads: Iterable[Load]) -> list[tuple[str, int]]:
    """Return the faces of the box that loads move or pull, each with the axis (0, 1, 2) along which."""
    found: dict[tuple[str, int], None] = {}
    for load in loads:
        found |= {
            (part.name, part.axis): None for part in (*load.held, *load.moved) if np.any(part.displacement)
        }
        for one in load.pulled:
            if one.name in BOX_PLANES:
                found[one.name, BOX_PLANES.index(one.name) // 2 if one.axis is None else one.axis] = None
    return list(found)


def face_loop(
    mesh: TetMesh, plane: str, axis: int, nodes: np.ndarray, displacement: np.ndarray, force: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the nominal strain and stress (k,) of a face along an axis, positive outwards, by name.

    displacement (k, n, 3) of the face's nodes (n,) of the mesh; force (k, 3): the sum of those on it. The
    strain is the mean displacement over the box's length across the face, the stress the force over the
    box's cross-section.
    """
    across, sign = BOX_PLANES.index(plane) // 2, 1.0 if plane.endswith("MAX") else -1.0
    lengths = np.ptp(mesh.box, axis=0)
    weights = nodal_forces([Traction(mesh.face_sets[plane], 1.0, plane, axis)], mesh)[nodes, axis]
    mean = displacement[:, :, axis] @ weights / weights.sum()
    area = np.delete(lengths, across).prod()
    name = f"{plane}.{'xyz'[axis]}"
    return {f"{name} strain": sign * mean / lengths[across], f"{name} stress": sign * force[:, axis] / area}
