"""What a solved increment shows: the deformed body, and the stress on a cut."""

from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from craftmesh.errors import CraftmeshError
from craftmesh.report.pictures import deformed_body, stress_on_plane
from craftmesh.report.shown_mesh import ShownMesh
from craftmesh.types import Solution, TetMesh


class SolvedMesh(NamedTuple):
    """A solved mesh; elements (m, 4) on points (p, 3) with stress (p, 6) as 11, 22, 33, 12, 13, 23."""

    mesh: TetMesh
    solution: Solution
    points: np.ndarray
    elements: np.ndarray
    stress: np.ndarray


def solved_pictures(solved: SolvedMesh, shown: ShownMesh) -> dict[str, Figure]:
    """Return pictures by name: `deformed`, and `stress` on a plane through the middle of the fronts.

    The plane is square to the axis that is most nearly along the crack, so that it shows the crack's trace.
    """
    found, needed = len(solved.solution.displacement), len(shown.points)
    if found < needed:
        raise CraftmeshError(
            f"the solution has {found} nodes and the mesh {needed}; give the solution of this mesh"
        )
    box = solved.mesh.box
    front = np.concatenate([*shown.fronts, np.zeros(0, np.int64)])
    middle = shown.points[front].mean(axis=0) if len(front) else box.mean(axis=0)
    principal = np.linalg.eigvalsh(_tensors(solved.stress[solved.elements].mean(axis=1)))[:, -1]
    axis = int(np.abs(shown.normal).argmin())
    moved = solved.solution.displacement[: len(shown.points)]
    return {
        "deformed": deformed_body(shown.points, shown.skin.triangles, moved, shown.towards),
        "stress": stress_on_plane(solved.points, solved.elements, principal, np.clip(middle, *box), axis),
    }


def _tensors(stress: np.ndarray) -> np.ndarray:
    """Return stresses (n, 6) as tensors (n, 3, 3)."""
    return stress[:, [[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
