"""A problem's field by conjugate gradients: from a field on to one that is exact enough."""

from collections.abc import Callable
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.solve.closed_pairs import ClosedPairs
from craftmesh.solve.conjugate_gradients import Matrix, conjugate_gradients
from craftmesh.solve.corners import Step, step_of
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.problem import Problem
from craftmesh.solve.stiffness_matrix import StiffnessMatrix, stiffness_matrix

# The residual that the iteration carries along parts from the true one by rounding and by the reactions,
# which change; it aims for half, and goes on from there where that was not enough.
_AIM = 0.5
# Forces under this share of those of uniform strain are rounding.
_AT_REST = 1e-6


class Found(NamedTuple):
    """A field (n, 3), the forces (p,) by which pairs of lip nodes push apart, and what is left.

    left (n, 3): forces out of balance; size: the length of reactions and forces that act; residual: as in
    `Problem.balance`.
    """

    displacement: np.ndarray
    push: np.ndarray
    left: np.ndarray
    size: float
    residual: float


class Iteration:
    """The matrix of a problem and its coarser levels, made once; `count`: the iterations so far.

    like: the iteration of another load on the same elements and supports, whose matrix and levels it takes.
    """

    def __init__(
        self,
        problem: Problem,
        options: SolveOptions,
        progress: Callable[[float, str], None],
        like: "Iteration | None" = None,
    ):
        self.problem, self.options, self.progress, self.like = problem, options, progress, like
        self.count, self.done = 0, 0.0
        self.first: Found | None = None

    @cached_property
    def matrix(self) -> StiffnessMatrix:
        """The stiffness matrix, supports taken out."""
        if self.like:
            return self.like.matrix
        return stiffness_matrix(self.problem.elements, self.problem.supports.fixed)

    @cached_property
    def step(self) -> Step:
        """One step of the preconditioner."""
        if self.like:
            return self.like.step
        matrix = self.matrix
        self.progress(0.1, "coarser levels")
        return step_of(self.problem.elements, matrix, self.problem.supports.fixed)

    def found(self, displacement: np.ndarray, closed: ClosedPairs | None) -> Found:
        """Return what a field (n, 3) leaves of the forces, after what closed pairs push."""
        left, reactions, residual = self.problem.balance(displacement)
        push = np.zeros(0)
        if closed is not None:
            push = closed.pushing(left)
            contact = closed.pairs.forces(push, left.shape)
            left, reactions, residual = self.problem.balance(displacement, contact)
        return Found(displacement, push, left, self.problem.size(reactions), residual)

    def solved(self, displacement: np.ndarray, closed: ClosedPairs | None, tolerance: float) -> Found:
        """Return the field with a residual of `tolerance` at most, from one (n, 3) on.

        A body that a crack severs may be free of stress, all but rounding: its field has no residual to go
        by and counts where little is left of the forces of the first field. Raises CraftmeshError where
        max_iterations, or any number, do not do.
        """
        now = self.found(displacement if closed is None else closed.closed(displacement), closed)
        first = self.first = self.first or now
        count = 0
        while not now.residual <= tolerance:
            if count == self.options.max_iterations:
                raise refused(now.residual, count, self.options)
            heard = partial(self._heard, now.size, "" if closed is None else closed.text)
            matrix, step = (self.matrix, self.step) if closed is None else _within(closed, self)
            goal, most = _AIM * tolerance * now.size, self.options.max_iterations - count
            change, used = conjugate_gradients(matrix, step, now.left, goal, most, heard)
            count, self.count = count + used, self.count + used
            before, now = now.residual, self.found(now.displacement + change, closed)
            if now.residual * now.size <= tolerance * first.size and now.size <= _AT_REST * first.size:
                return now
            if not now.residual < before:  # rounding, or not a number: more of the same would not help
                raise refused(now.residual, count, self.options)
        return now

    def _heard(self, size: float, text: str, out: float) -> None:
        first = self.first.residual if self.first else 1.0
        if first > self.options.tolerance:
            done = np.log(out / size / first) / np.log(self.options.tolerance / first)
            self.done = max(self.done, 0.2 + 0.8 * min(max(done, 0.0), 1.0))
        self.progress(self.done, f"{text}residual {out / size:.1e}")


class _Constrained(NamedTuple):
    """A matrix on the fields that keep pairs closed."""

    matrix: StiffnessMatrix
    closed: ClosedPairs

    def times(self, x: np.ndarray, out: np.ndarray) -> float:
        product = self.matrix.times(x, out)
        self.closed.take_out(out)
        return product


def _within(closed: ClosedPairs, whole: Iteration) -> tuple[Matrix, Step]:
    """Return the matrix and the step of an iteration on the fields that keep pairs closed."""

    def step(right: np.ndarray, out: np.ndarray) -> None:
        whole.step(right, out)
        closed.take_out(out)

    return _Constrained(whole.matrix, closed), step


def refused(residual: float, iterations: int, options: SolveOptions) -> CraftmeshError:
    return CraftmeshError(
        f"solve: the residual is {residual:.1e} after {iterations} iterations, expected at most "
        f"{options.tolerance:g}; look for flat elements (craftmesh check), raise max_iterations or "
        "tolerance, or take another solver"
    )
