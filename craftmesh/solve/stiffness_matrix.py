"""The stiffness matrix of a body with its supports taken out."""

from dataclasses import dataclass

import numpy as np

from craftmesh.solve.elements import Elements
from craftmesh.solve.kernels.assembly import assemble_blocks, take_out, upper_pattern
from craftmesh.solve.kernels.blocks import inverted, multiply


@dataclass(frozen=True, eq=False)
class StiffnessMatrix:
    """Symmetric matrix of 3 x 3 blocks by nodes: those on the diagonal (n, 3, 3) and above it.

    start (n + 1,), column and upper (k, 3, 3): the blocks of node i above the diagonal are upper[start[i] :
    start[i + 1]], to the nodes `column` there. Prescribed displacements have no block but the number on the
    diagonal.
    """

    start: np.ndarray
    column: np.ndarray
    upper: np.ndarray
    diagonal: np.ndarray

    @property
    def triangle(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """start, column and upper, as the kernels take them."""
        return self.start, self.column, self.upper

    def inverse_diagonal(self) -> np.ndarray:
        """Return the inverses (n, 3, 3) of the blocks on the diagonal."""
        return inverted(self.diagonal)

    def times(self, x: np.ndarray, out: np.ndarray) -> float:
        """Fill `out` (n, 3) with the matrix times x (n, 3); return x . out."""
        return multiply(*self.triangle, self.diagonal, x, out)


def stiffness_matrix(elements: Elements, fixed: np.ndarray) -> StiffnessMatrix:
    """Return the matrix of the elements; fixed (n, 3) bool: prescribed displacements."""
    start, column = upper_pattern(elements.tets, len(elements.points))
    diagonal, upper = assemble_blocks(*elements.tables, start, column)
    take_out(fixed, start, column, diagonal, upper)
    return StiffnessMatrix(start, column, upper, diagonal)
