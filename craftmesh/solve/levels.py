"""The stiffness matrix of a body, and its preconditioner of several levels.

A step of the preconditioner sweeps over the nodes of a level and adds the correction of the next coarser
level. Below 10-node elements these are the corners as 4-node elements, below them aggregates of nodes.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, csr_array, eye_array, triu

from craftmesh.mechanics.rigid_body_supports import rigid_motions
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS
from craftmesh.solve.kernels.assembly import assemble_blocks
from craftmesh.solve.kernels.blocks import (
    multiply,
    negative_upper,
    solve_lower,
    solve_upper,
    subtract_lower,
)
from craftmesh.solve.problem import Elements

# Largest number of unknowns of the coarsest level: factorising a larger matrix costs more than it saves.
COARSEST = 300
_SMOOTHER = ("gauss_seidel", {"sweep": "symmetric"})
# Fills its second argument (n, 3) with an approximate solution or a correction for the first (n, 3).
Step = Callable[[np.ndarray, np.ndarray], None]


@dataclass(frozen=True, eq=False)
class StiffnessMatrix:
    """Symmetric matrix of 3 x 3 blocks by nodes: blocks on the diagonal (n, 3, 3) and above it.

    start (n + 1,), column (k,) and upper (k, 3, 3): node i has the blocks upper[start[i] : start[i + 1]]
    above the diagonal, in the columns of the nodes column[start[i] : start[i + 1]]. Rows and columns of
    prescribed displacements are 0 except on the diagonal.
    """

    start: np.ndarray
    column: np.ndarray
    upper: np.ndarray
    diagonal: np.ndarray

    @property
    def triangle(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """start, column and upper, in the order of the kernels' arguments."""
        return self.start, self.column, self.upper

    def whole(self) -> bsr_array:
        """Return the full matrix (3n, 3n) in sparse blocks; blocks of zeros are left out."""
        n = len(self.diagonal)
        upper = bsr_array((self.upper, self.column, self.start), shape=(3 * n, 3 * n))
        return upper + upper.T + bsr_array((self.diagonal, np.arange(n), np.arange(n + 1)), upper.shape)

    def times(self, x: np.ndarray, out: np.ndarray) -> float:
        """Fill `out` (n, 3) with the matrix times x (n, 3); return x . out."""
        return multiply(*self.triangle, self.diagonal, x, out)


def stiffness_matrix(elements: Elements, fixed: np.ndarray) -> StiffnessMatrix:
    """Return the matrix of the elements; fixed (n, 3) bool: mask of prescribed displacements.

    Rows and columns of prescribed displacements are 0 except on the diagonal: if a right-hand side is 0
    there, its solution is too. A node without an element has 1 on the diagonal.
    """
    start, column = _upper_pattern(elements.tets, len(elements.points))
    diagonal, upper = assemble_blocks(*elements.tables, start, column)
    row = np.repeat(np.arange(len(fixed)), np.diff(start))
    holds = np.asarray(fixed.any(axis=1))
    at = np.flatnonzero(holds[row] | holds[column])
    upper[at] *= ~(fixed[row[at]][:, :, None] | fixed[column[at]][:, None, :])
    own = np.eye(3, dtype=bool)
    diagonal *= own | ~(fixed[:, :, None] | fixed[:, None, :])
    diagonal[own & (diagonal == 0)] = 1.0
    return StiffnessMatrix(start, column, upper, diagonal)


def _upper_pattern(tets: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return start (n + 1,) and column (k,) of the blocks above the diagonal, one per pair of nodes."""
    first = np.arange(0, tets.size + 1, tets.shape[1])
    touches = csr_array((np.ones(tets.size, bool), tets.ravel(), first), (len(tets), count))
    pattern = triu(touches.T @ touches, k=1, format="csr")
    pattern.sort_indices()
    return pattern.indptr.astype(np.int64), pattern.indices.astype(np.int32)


class Aggregates:
    """One V-cycle of smoothed aggregation (Vanek, Mandel & Brezina 1996) below 4-node elements.

    The prolongation is smoothed with a separate weight for each row of the matrix, because pyamg's common
    weight depends on random numbers.
    """

    def __init__(self, elements: Elements, matrix: StiffnessMatrix, fixed: np.ndarray):
        from pyamg import smoothed_aggregation_solver
        from pyamg.multilevel import MultilevelSolver

        levels = smoothed_aggregation_solver(
            matrix.whole(),
            B=rigid_motions(elements.points).reshape(fixed.size, 6) * ~fixed.reshape(-1, 1),
            strength=("symmetric", {"theta": 0.0}),
            smooth=("jacobi", {"weighting": "local"}),
            presmoother=_SMOOTHER,
            postsmoother=_SMOOTHER,
            improve_candidates=None,
            max_coarse=COARSEST,
            coarse_solver="splu",
        ).levels
        if len(levels) > 1:  # the first level has sweeps of its own
            self.prolongation = levels[0].P
            levels = levels[1:]
        else:
            self.prolongation = eye_array(fixed.size, format="csr")
        self.restriction = self.prolongation.T.tocsr()
        self.cycle = MultilevelSolver(levels, coarse_solver="splu").aspreconditioner(cycle="V")

    def __call__(self, left: np.ndarray, out: np.ndarray) -> None:
        """Fill `out` (n, 3) with the coarser levels' correction for the residual `left` (n, 3)."""
        answer = self.cycle.matvec(self.restriction @ left.ravel())
        np.copyto(out, (self.prolongation @ answer).reshape(-1, 3))


def sweeps(matrix: StiffnessMatrix, correct: Step) -> Step:
    """Return an approximate inverse of a stiffness matrix L + D + U, symmetric and positive definite.

    For a right-hand side r: x solves (L + D) x = r; the coarser level gives a correction e for the residual
    -U x; t solves (D + U) t = -U x - L e. The result is x + t, which contains e. `correct(left, out)` fills
    `out` (n, 3) with the coarser level's correction for a residual.
    """
    triangle, inverse = matrix.triangle, np.linalg.inv(matrix.diagonal)
    left, e = np.empty((2, len(inverse), 3))

    def step(right: np.ndarray, out: np.ndarray) -> None:
        np.copyto(left, right)
        solve_lower(*triangle, inverse, left, out)
        negative_upper(*triangle, out, left)
        correct(left, e)
        subtract_lower(*triangle, e, left)
        solve_upper(*triangle, inverse, left, e)
        out += e

    return step


def step_of(elements: Elements, matrix: StiffnessMatrix, fixed: np.ndarray) -> Step:
    """Return the preconditioner step(right, out) of the elements' matrix.

    fixed (n, 3): mask of prescribed displacements.
    """
    if elements.tets.shape[1] == 4:
        return sweeps(matrix, Aggregates(elements, matrix, fixed))
    return sweeps(matrix, Corners(elements, fixed))


class Corners:
    """The preconditioner's level of 4-node elements on the corners of 10-node elements.

    Its corrections are linear along each edge.
    """

    def __init__(self, elements: Elements, fixed: np.ndarray):
        tets, count = elements.tets, len(elements.points)
        self.corner, self.fixed = np.unique(tets[:, :4]), fixed
        number = np.zeros(count, np.int64)
        number[self.corner] = np.arange(len(self.corner))
        mid, first = np.unique(tets[:, 4:], return_index=True)
        tet, edge = np.divmod(first, 6)
        ends = tets[tet[:, None], EDGE_CORNERS[edge]]
        share = _shares(elements.points, mid, ends)
        rows = np.concatenate([self.corner, mid, mid])
        columns = np.concatenate([self.corner, ends[:, 0], ends[:, 1]])
        values = np.concatenate([np.ones(len(self.corner)), 1 - share, share])
        self.spread = csr_array((values, (rows, number[columns])), (count, len(self.corner)))
        self.gather = self.spread.T.tocsr()
        self.answer = np.empty((len(self.corner), 3))
        grains = elements.part, elements.stiffness
        linear = Elements(elements.points[self.corner], number[tets[:, :4]], *grains, rule=1)
        held = fixed[self.corner]
        self.step = step_of(linear, stiffness_matrix(linear, held), held)

    def __call__(self, left: np.ndarray, out: np.ndarray) -> None:
        """Fill `out` (n, 3) with the corner level's correction for the residual `left` (n, 3)."""
        right = self.gather @ np.where(self.fixed, 0.0, left)
        self.step(np.where(self.fixed[self.corner], 0.0, right), self.answer)
        np.copyto(out, np.where(self.fixed, 0.0, self.spread @ self.answer))


def _shares(points: np.ndarray, mid: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the positions (k,) of mid nodes along their edges, 0 at the first end to 1 at the second.

    Quarter points are not at 0.5; with their positions, rigid motions of corners move mid nodes rigidly.
    """
    along = points[ends[:, 1]] - points[ends[:, 0]]
    reach = np.einsum("ij,ij->i", points[mid] - points[ends[:, 0]], along)
    return np.clip(reach / np.einsum("ij,ij->i", along, along), 0, 1)
