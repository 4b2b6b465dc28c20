"""The built-in solver: linear elasticity by preconditioned conjugate gradients on two levels."""

from collections.abc import Callable

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.model import ElasticModel
from craftmesh.progress import silent
from craftmesh.solve.conjugate_gradients import conjugate_gradients
from craftmesh.solve.corners import step_of
from craftmesh.solve.options import BUILTIN, SolveOptions
from craftmesh.solve.problem import DECK_RULE, Problem, problem_of
from craftmesh.solve.stiffness_matrix import stiffness_matrix
from craftmesh.solve.supports import Supports
from craftmesh.types import Solution, TetMesh

# The residual that the iteration carries along parts from the true one by rounding and by the reactions,
# which change; it aims for half, and goes on from there where that was not enough.
_AIM = 0.5
# Bytes for a node of 4- and 10-node elements, and gigabytes for Python and its libraries: measured with
# benchmarks/solve.py, rounded up.
_PER_NODE = {4: 4000, 10: 2000}
_AT_REST = 0.4
# Supports in a plane say nothing of the strain across it: eigenvalues of their moments under this share of
# the largest are rounding.
_FLAT = 1e-10
FULL_RULE = 14


def solve(
    model: ElasticModel,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (frozen)
    progress: Callable[[float, str], None] = silent,
) -> tuple[Solution, dict]:
    """Return the solution of a model and a report: unknowns, memory in GB, iterations, residual.

    Elements are integrated as C3D4 and C3D10 are in Abaqus and CalculiX, unless told otherwise, so that all
    three find the same field. The same model gives the same bits. Raises CraftmeshError for a
    load that `problem_of` refuses, for more memory than the limit, and for a field that does not become
    exact enough.
    """
    memory = memory_of(model.mesh)
    report = {"unknowns": model.mesh.points.size, "memory_gb": round(memory, 2)}
    if memory > options.memory_limit:
        raise CraftmeshError(
            f"memory_limit: {model.mesh.points.size} unknowns need about {memory:.1f} GB, the limit is "
            f"{options.memory_limit:g} GB; raise it, take longer edges, or another solver"
        )
    progress(0.0, f"{model.mesh.points.size} unknowns, about {memory:.1f} GB")
    problem = problem_of(model, DECK_RULE if options.integration == "deck" else FULL_RULE)
    displacement, iterations = _iterate(problem, options, progress)
    _, reactions, residual = problem.balance(displacement)
    found = {"iterations": iterations, "residual": residual}
    return Solution(displacement, reactions, {"solver": BUILTIN, **found}), report | found


def memory_of(mesh: TetMesh) -> float:
    """Return about how many gigabytes the solver will need for a mesh."""
    return _AT_REST + 1e-9 * _PER_NODE[mesh.tets.shape[1]] * len(mesh.points)


def _iterate(
    problem: Problem, options: SolveOptions, progress: Callable[[float, str], None]
) -> tuple[np.ndarray, int]:
    """Return the displacement (n, 3) and the number of iterations that it took."""
    displacement = _start(problem.elements.points, problem.supports)
    left, _, residual = problem.balance(displacement)
    first, iterations = residual, 0
    if residual <= options.tolerance:
        return displacement, iterations
    fixed = problem.supports.fixed
    matrix = stiffness_matrix(problem.elements, fixed)
    progress(0.1, "coarser levels")
    step = step_of(problem.elements, matrix, fixed)
    while not residual <= options.tolerance:
        if iterations == options.max_iterations:
            raise _refused(residual, iterations, options)
        size = np.sqrt((left**2).sum()) / residual

        def heard(out: float, size: float = size) -> None:
            done = np.log(out / size / first) / np.log(options.tolerance / first)
            progress(0.2 + 0.8 * min(max(done, 0.0), 1.0), f"residual {out / size:.1e}")

        goal = _AIM * options.tolerance * size
        most = options.max_iterations - iterations
        change, count = conjugate_gradients(matrix, step, left, goal, most, heard)
        before, iterations = residual, iterations + count
        displacement += change
        left, _, residual = problem.balance(displacement)
        if not residual < before:  # rounding, or not a number: more of the same would not help
            raise _refused(residual, iterations, options)
    return displacement, iterations


def _start(points: np.ndarray, supports: Supports) -> np.ndarray:
    """Return the field (n, 3) of uniform strain that fits the supports best, their values put in.

    Sums are einsum's: those of BLAS go by the number of threads, and the last bits with them.
    """
    middle = points.mean(axis=0)
    places = np.column_stack([np.ones(len(points)), (points - middle) / np.ptp(points, axis=0).max()])
    field = np.empty(points.shape)
    for axis in range(3):
        fixed = supports.fixed[:, axis]
        values = supports.displacement[fixed, axis]
        moments = np.einsum("ka,kb->ab", places[fixed], places[fixed])
        inverse = np.linalg.pinv(moments, rcond=_FLAT, hermitian=True)
        strain = inverse @ np.einsum("ka,k->a", places[fixed], values)
        field[:, axis] = np.einsum("na,a->n", places, strain)
        field[fixed, axis] = values
    return field


def _refused(residual: float, iterations: int, options: SolveOptions) -> CraftmeshError:
    return CraftmeshError(
        f"solve: the residual is {residual:.1e} after {iterations} iterations, expected at most "
        f"{options.tolerance:g}; look for flat elements (craftmesh check), raise max_iterations or "
        "tolerance, or take another solver"
    )
