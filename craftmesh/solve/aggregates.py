"""The coarser levels of linear elements: aggregates of nodes with their rigid motions, by pyamg."""

import numpy as np

from craftmesh.mechanics.holding import rigid_motions
from craftmesh.solve.elements import Elements
from craftmesh.solve.kernels.blocks import all_blocks
from craftmesh.solve.stiffness_matrix import StiffnessMatrix

# Levels end here: the factor of a larger one costs more than it saves.
COARSEST = 300
_SMOOTHER = ("gauss_seidel", {"sweep": "symmetric"})


class Aggregates:
    """One V-cycle of smoothed aggregation (Vanek, Mandel & Brezina 1996) below linear elements.

    Each row of the matrix gives its own weight to the smoothing of the prolongation: pyamg finds a common
    one from random numbers.
    """

    def __init__(self, elements: Elements, matrix: StiffnessMatrix, fixed: np.ndarray):
        from pyamg import smoothed_aggregation_solver
        from pyamg.multilevel import MultilevelSolver
        from scipy.sparse import bsr_array, eye_array

        first, at, blocks = all_blocks(*matrix.triangle, matrix.diagonal)
        levels = smoothed_aggregation_solver(
            bsr_array((blocks, at, first.astype(np.int32)), shape=(fixed.size, fixed.size)),
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
        """Fill `out` (n, 3) with the aggregates' answer to what is left (n, 3)."""
        answer = self.cycle.matvec(self.restriction @ left.ravel())
        np.copyto(out, (self.prolongation @ answer).reshape(-1, 3))
