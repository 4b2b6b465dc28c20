"""One step towards the answer: a sweep forward, a correction on a coarser level, a sweep back."""

from collections.abc import Callable

import numpy as np

from craftmesh.solve.kernels.blocks import negative_upper, solve_lower, solve_upper, subtract_lower
from craftmesh.solve.stiffness_matrix import StiffnessMatrix


class Sweeps:
    """An approximate inverse of a stiffness matrix L + D + U, symmetric and positive definite.

    From a right-hand side r: x by (L + D) x = r; what is left, -U x, has the coarser level's answer e; then
    t by (D + U) t = -U x - L e. The answer is x + t, which holds e already. `correct(left, out)` fills
    `out` (n, 3) with the answer of the coarser level.
    """

    def __init__(self, matrix: StiffnessMatrix, correct: Callable[[np.ndarray, np.ndarray], None]):
        self.matrix, self.correct = matrix, correct
        self.inverse = matrix.inverse_diagonal()
        self.left, self.e = np.empty((2, len(matrix.diagonal), 3))

    def __call__(self, right: np.ndarray, out: np.ndarray) -> None:
        """Fill `out` (n, 3) with the approximate answer to `right` (n, 3)."""
        triangle = self.matrix.triangle
        np.copyto(self.left, right)
        solve_lower(*triangle, self.inverse, self.left, out)
        negative_upper(*triangle, out, self.left)
        self.correct(self.left, self.e)
        subtract_lower(*triangle, self.e, self.left)
        solve_upper(*triangle, self.inverse, self.left, self.e)
        out += self.e
