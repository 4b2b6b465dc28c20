"""The coarser level of 10-node elements: linear elements on their corners."""

from collections.abc import Callable

import numpy as np

from craftmesh.mesh.tet_connectivity import EDGE_CORNERS
from craftmesh.solve.aggregates import Aggregates
from craftmesh.solve.elements import Elements
from craftmesh.solve.kernels.transfer import to_corners, to_nodes
from craftmesh.solve.stiffness_matrix import StiffnessMatrix, stiffness_matrix
from craftmesh.solve.sweeps import Sweeps

Step = Callable[[np.ndarray, np.ndarray], None]


def step_of(elements: Elements, matrix: StiffnessMatrix, fixed: np.ndarray) -> Step:
    """Return a step(right, out) towards the answer of the elements' matrix; fixed (n, 3) prescribed."""
    if elements.tets.shape[1] == 4:
        return Sweeps(matrix, Aggregates(elements, matrix, fixed))
    return Sweeps(matrix, Corners(elements, fixed))


class Corners:
    """Answers on the corners of 10-node elements, and between them linear along each edge."""

    def __init__(self, elements: Elements, fixed: np.ndarray):
        tets = elements.tets
        corner = np.unique(tets[:, :4])
        number = np.zeros(len(elements.points), np.int64)
        number[corner] = np.arange(len(corner))
        mid, first = np.unique(tets[:, 4:], return_index=True)
        tet, edge = np.divmod(first, 6)
        ends = tets[tet[:, None], EDGE_CORNERS[edge]]
        self.links = corner, mid, number[ends], _shares(elements.points, mid, ends), fixed
        self.right, self.answer = np.empty((2, len(corner), 3))
        grains = elements.part, elements.stiffness
        linear = Elements(elements.points[corner], number[tets[:, :4]], *grains, rule=1)
        self.step = step_of(linear, stiffness_matrix(linear, fixed[corner]), fixed[corner])

    def __call__(self, left: np.ndarray, out: np.ndarray) -> None:
        """Fill `out` (n, 3) with the corners' answer to what is left (n, 3)."""
        to_corners(*self.links, left, self.right)
        self.step(self.right, self.answer)
        to_nodes(*self.links, self.answer, out)


def _shares(points: np.ndarray, mid: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return how far (k,) mid nodes lie along their edges, 0 to 1, so that rigid motions stay rigid."""
    along = points[ends[:, 1]] - points[ends[:, 0]]
    reach = np.einsum("ij,ij->i", points[mid] - points[ends[:, 0]], along)
    return np.clip(reach / np.einsum("ij,ij->i", along, along), 0, 1)
