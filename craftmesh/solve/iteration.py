"""A problem's field by conjugate gradients, which keep closed pairs of opposite lip nodes closed."""

from collections.abc import Callable
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import scipy
from scipy.sparse import csr_array, eye_array

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.lips import LipPairs
from craftmesh.solve.kernels.blocks import dot
from craftmesh.solve.levels import Step, StiffnessMatrix, step_of, stiffness_matrix
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.problem import Problem

# Number added to the diagonal of the products of constraints, whose entries there are 2. Where cracks cross
# under supports, a constraint may follow from others; with this number the system still has a solution.
_DEPENDENT = 1e-12
# Goal of the iteration over the tolerance. The residual in the iteration differs from the true one by
# rounding and by the reactions, which change. If the true residual is then too large, the iteration
# continues.
_AIM = 0.5
# Fraction of the forces of the starting field below which forces are rounding.
_AT_REST = 1e-6


def conjugate_gradients(
    times: Callable[[np.ndarray, np.ndarray], float],
    precondition: Step,
    right: np.ndarray,
    goal: float,
    most: int,
    heard: Callable[[float], None],
) -> tuple[np.ndarray, int]:
    """Return x (n, 3) with |right - A x| <= goal, or after `most` iterations, and the number of iterations.

    times(x, out) fills `out` with the symmetric positive definite A times x and returns x . out;
    precondition(r, out) fills `out` with an approximate solution for r; heard(|r|) is called in each
    iteration. The residual r is updated by recursion, so that rounding makes it differ from the true one.
    """
    x, residual = np.zeros_like(right), right.copy()
    answer, product = np.empty_like(right), np.empty_like(right)
    direction = np.zeros_like(right)
    before = 1.0
    for iteration in range(most):
        size = np.sqrt(dot(residual, residual))
        heard(size)
        if not size > goal:  # converged, or not a number
            return x, iteration
        precondition(residual, answer)
        weight = dot(residual, answer)
        direction *= weight / before
        direction += answer
        before = weight
        step = weight / times(direction, product)
        x += step * direction
        residual -= step * product
    return x, most


class ClosedPairs:
    """Pairs of opposite lip nodes that touch: components of their jump that stay 0, and friction forces.

    axes (p, 3, 3): three unit vectors of each pair as rows; held (p, 3): mask of the axes along which the
    jump of a pair, the displacement of its first node minus that of its second, stays 0; friction: drag and
    spring (p, 3), by which a jump J gives the force drag - spring (spring . J) on the first node; fixed (n,
    3): mask of prescribed components; text: start of the progress messages. A held axis is a row c of the
    matrix `free`, 0 at prescribed components. Rows of `whole` have all components, so that whole @ u are
    the jumps of a displacement u. The solver keeps its updates of a field orthogonal to all c.
    """

    def __init__(
        self,
        pairs: LipPairs,
        axes: np.ndarray,
        held: np.ndarray,
        friction: tuple[np.ndarray, np.ndarray],
        fixed: np.ndarray,
        text: str,
    ):
        self.pairs, self.text, self.fixed = pairs, text, fixed
        self.at, axis = np.nonzero(held)
        self.axes = axes[self.at, axis]
        self.drag, self.spring = friction
        self.stretch, free = _jumps(pairs.nodes, self.spring, fixed)
        self.loosen = free.T.tocsr()
        self.whole, self.free = _jumps(pairs.nodes[self.at], self.axes, fixed)
        self.spread = self.free.T.tocsr()
        product = self.free @ self.spread + _DEPENDENT * eye_array(len(self.at))
        self.answer = scipy.sparse.linalg.splu(product.tocsc()).solve if len(self.at) else np.copy

    def take_out(self, field: np.ndarray) -> None:
        """Remove from a field (n, 3), in place, the part that changes the held jumps."""
        field -= (self.spread @ self.answer(self.free @ field.ravel())).reshape(field.shape)

    def closed(self, displacement: np.ndarray) -> np.ndarray:
        """Return the displacement (n, 3) changed so that the held jumps are 0."""
        jumps = self.whole @ displacement.ravel()
        return displacement - (self.spread @ self.answer(jumps)).reshape(displacement.shape)

    def rubbed(self, displacement: np.ndarray) -> np.ndarray:
        """Return the friction forces (p, 3) on the pairs' first nodes at a displacement (n, 3)."""
        return self.drag - (self.stretch @ displacement.ravel())[:, None] * self.spring

    def pushing(self, left: np.ndarray) -> np.ndarray:
        """Return forces (p, 3) on the first nodes that, along held axes, best balance `left` (n, 3)."""
        push = np.zeros(self.drag.shape)
        np.add.at(push, self.at, -self.answer(self.free @ left.ravel())[:, None] * self.axes)
        return push


def _jumps(nodes: np.ndarray, axes: np.ndarray, fixed: np.ndarray) -> tuple[csr_array, csr_array]:
    """Return two matrices (k, 3 n) that give jumps of displacements between nodes (k, 2) along axes (k, 3).

    The second matrix is 0 at prescribed components, fixed (n, 3).
    """
    column = (3 * nodes[:, :, None] + np.arange(3)).ravel()
    value = (np.array([1.0, -1.0])[:, None] * axes[:, None, :]).ravel()
    first = 6 * np.arange(len(nodes) + 1)
    free = np.where(fixed.ravel()[column], 0.0, value)
    whole, free = (csr_array((own, column, first), (len(nodes), fixed.size)) for own in (value, free))
    return whole, free


class Found(NamedTuple):
    """A field (n, 3), the forces `push` (p, 3) on the first nodes of pairs of lip nodes, and the imbalance.

    left (n, 3): forces out of balance; size: norm of reactions and applied forces; residual: norm of `left`
    over size. push has shape (0, 3) without contact.
    """

    displacement: np.ndarray
    push: np.ndarray
    left: np.ndarray
    size: float
    residual: float


class Iteration:
    """The iterative solution of a problem, whose matrix and coarser levels are made at first use.

    count: number of iterations so far; like: the iteration of another load on the same elements and
    supports, whose matrix and levels are reused.
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
        """The stiffness matrix, with the prescribed displacements eliminated."""
        if self.like:
            return self.like.matrix
        return stiffness_matrix(self.problem.elements, self.problem.supports.fixed)

    @cached_property
    def step(self) -> Step:
        """The preconditioner: step(right, out) fills `out` with an approximate solution for `right`."""
        if self.like:
            return self.like.step
        matrix = self.matrix
        self.progress(0.1, "coarser levels")
        return step_of(self.problem.elements, matrix, self.problem.supports.fixed)

    def found(self, displacement: np.ndarray, closed: ClosedPairs | None) -> Found:
        """Return the imbalance of a field (n, 3), with the forces of closed pairs that balance it best."""
        left, reactions, residual = self.problem.balance(displacement)
        push = np.zeros((0, 3))
        if closed is not None:
            push = closed.rubbed(displacement)
            left += np.where(closed.fixed, 0.0, closed.pairs.forces(push, left.shape))
            push += closed.pushing(left)
            contact = closed.pairs.forces(push, left.shape)
            left, reactions, residual = self.problem.balance(displacement, contact)
        return Found(displacement, push, left, self.problem.size(reactions), residual)

    def solved(self, displacement: np.ndarray, closed: ClosedPairs | None, tolerance: float) -> Found:
        """Return the field with a residual of at most `tolerance`, iterated from displacement (n, 3).

        A body that a crack severs may be free of stress up to rounding, so that its residual means nothing.
        Its field is accepted once both its forces and the forces out of balance are negligible against
        those of the first field. Raises CraftmeshError if max_iterations are not enough, or if the residual
        no longer falls.
        """
        now = self.found(displacement if closed is None else closed.closed(displacement), closed)
        first = self.first = self.first or now
        count = 0
        while not now.residual <= tolerance:
            if count == self.options.max_iterations:
                raise refused(now.residual, count, self.options)
            heard = partial(self._heard, now.size, "" if closed is None else closed.text)
            times, step = (self.matrix.times, self.step) if closed is None else _within(closed, self)
            goal, most = _AIM * tolerance * now.size, self.options.max_iterations - count
            change, used = conjugate_gradients(times, step, now.left, goal, most, heard)
            count, self.count = count + used, self.count + used
            before, now = now.residual, self.found(now.displacement + change, closed)
            if now.residual * now.size <= tolerance * first.size and now.size <= _AT_REST * first.size:
                return now
            if not now.residual < before:  # rounding, or not a number: more iterations would not help
                raise refused(now.residual, count, self.options)
        return now

    def _heard(self, size: float, text: str, out: float) -> None:
        first = self.first.residual if self.first else 1.0
        if first > self.options.tolerance:
            done = np.log(out / size / first) / np.log(self.options.tolerance / first)
            self.done = max(self.done, 0.2 + 0.8 * min(max(done, 0.0), 1.0))
        self.progress(self.done, f"{text}residual {out / size:.1e}")


def _within(
    closed: ClosedPairs, whole: Iteration
) -> tuple[Callable[[np.ndarray, np.ndarray], float], Step]:
    """Return the matrix product and the preconditioner for fields that keep the pairs closed."""

    def times(x: np.ndarray, out: np.ndarray) -> float:
        product = whole.matrix.times(x, out)
        stretch = closed.stretch @ x.ravel()
        out += (closed.loosen @ stretch).reshape(out.shape)
        closed.take_out(out)
        return product + float((stretch**2).sum())

    def step(right: np.ndarray, out: np.ndarray) -> None:
        whole.step(right, out)
        closed.take_out(out)

    return times, step


def refused(residual: float, iterations: int, options: SolveOptions) -> CraftmeshError:
    """Return the error for a field whose residual stays too large."""
    return CraftmeshError(
        f"solve: the residual is {residual:.1e} after {iterations} iterations, expected at most "
        f"{options.tolerance:g}; look for flat elements (craftmesh check), raise max_iterations or "
        "tolerance, or use another solver"
    )
