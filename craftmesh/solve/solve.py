"""The built-in solver: linear elasticity by preconditioned conjugate gradients on two levels."""

from collections.abc import Callable

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.lip_pairs import lip_pairs
from craftmesh.progress import silent
from craftmesh.solve.compressibility import check_compressible
from craftmesh.solve.contact import least_overlap, overlap_of, with_contact
from craftmesh.solve.iteration import Iteration, refused
from craftmesh.solve.options import BUILTIN, SolveOptions
from craftmesh.solve.problem import DECK_RULE, problem_of
from craftmesh.solve.supports import Supports
from craftmesh.types import Solution, TetMesh

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
    three find the same field. Where lips of the crack would overlap in it they press on each other, unless
    told otherwise, and both returns say so; else nothing is changed. The same model gives the same bits.
    Raises CraftmeshError for a material that is nearly incompressible, a load that `problem_of` refuses,
    more memory than the limit, and a field that does not become exact enough.
    """
    check_compressible(model)
    memory = memory_of(model.mesh)
    report = {"unknowns": model.mesh.points.size, "memory_gb": round(memory, 2)}
    if memory > options.memory_limit:
        raise CraftmeshError(
            f"memory_limit: {model.mesh.points.size} unknowns need about {memory:.1f} GB, the limit is "
            f"{options.memory_limit:g} GB; raise it, take longer edges, or another solver"
        )
    progress(0.0, f"{model.mesh.points.size} unknowns, about {memory:.1f} GB")
    problem = problem_of(model, DECK_RULE if options.integration == "deck" else FULL_RULE)
    iteration = Iteration(problem, options, progress)
    found = iteration.solved(_start(problem.elements.points, problem.supports), None, options.tolerance)
    forces, contact_figures = None, {}
    if options.contact:
        pairs = lip_pairs(model.mesh)
        overlap = overlap_of(pairs, found.displacement)
        if overlap > least_overlap(found.displacement, options.tolerance):
            contact = with_contact(iteration, pairs, found.displacement)
            found, forces = contact.found, pairs.forces(contact.found.push, problem.forces.shape)
            contact_figures = contact.figures() | {"overlap_without_contact": overlap}
    _, reactions, residual = problem.balance(found.displacement, forces)
    if not residual <= options.tolerance:
        raise refused(residual, iteration.count, options)
    figures = {"iterations": iteration.count, "residual": residual} | contact_figures
    return Solution(found.displacement, reactions, {"solver": BUILTIN, **figures}, forces), report | figures


def memory_of(mesh: TetMesh) -> float:
    """Return about how many gigabytes the solver will need for a mesh."""
    return _AT_REST + 1e-9 * _PER_NODE[mesh.tets.shape[1]] * len(mesh.points)


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
