"""What a growing case shows: its crack, what drives it, and the last increment's body and stress."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.report.pictures import along_front, crack_by_increment, deformed_body, stress_on_plane
from craftmesh.surface.measure import area_vectors
from craftmesh.types import Crack, Solution, TetMesh


class SolvedMesh(NamedTuple):
    """A solved mesh; elements (m, 4) on points (p, 3) with stress (p, 6) as 11, 22, 33, 12, 13, 23."""

    mesh: TetMesh
    solution: Solution
    points: np.ndarray
    elements: np.ndarray
    stress: np.ndarray


def growth_pictures(
    cracks: Mapping[str, Crack], rows: Mapping[str, Mapping[str, np.ndarray]], last: SolvedMesh
) -> list[tuple[str, bytes]]:
    """Return captions and .png pictures of a case: cracks and columns of sif.csv by increments' names."""
    points = last.mesh.points
    box = last.mesh.box
    crack = list(cracks.values())[-1]
    facing = np.abs(area_vectors(crack.points, crack.triangles).sum(axis=0))
    middle = np.concatenate([crack.points[front] for front in crack.fronts]).mean(axis=0)
    principal = np.linalg.eigvalsh(_tensors(last.stress[last.elements].mean(axis=1)))[:, -1]
    return [
        ("crack by increment", crack_by_increment(cracks, box)),
        ("along the front", along_front(rows)),
        ("deformed body, last increment", deformed_body(points, _outside(last.mesh), _moved(last))),
        (
            "stress on a cut, last increment",
            stress_on_plane(
                last.points, last.elements, principal, np.clip(middle, *box), int(facing.argmin())
            ),
        ),
    ]


def _outside(mesh: TetMesh) -> np.ndarray:
    """Return the free facets (k, 3) that are no lip of a crack."""
    names = [name for name in mesh.face_sets if not is_lip(name)]
    return np.concatenate([mesh.outward_triangles(name)[:, :3] for name in names])


def _moved(last: SolvedMesh) -> np.ndarray:
    """Return the displacement of the mesh's nodes, which come first in the deck."""
    return last.solution.displacement[: len(last.mesh.points)]


def _tensors(stress: np.ndarray) -> np.ndarray:
    """Return stresses (n, 6) as tensors (n, 3, 3)."""
    return stress[:, [[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
