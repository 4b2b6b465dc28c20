"""The built-in solver: linear elasticity by preconditioned conjugate gradients on several levels."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from craftmesh.arguments import typed
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import RESIDUAL
from craftmesh.mechanics.materials import mean_moduli
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import DECK_RULE, FULL_RULE
from craftmesh.mesh.lips import lip_pairs
from craftmesh.progress import silent
from craftmesh.solve.contact import least_overlap, overlap_of, with_contact
from craftmesh.solve.foreign import FieldOf, foreign_solutions
from craftmesh.solve.iteration import Iteration, refused
from craftmesh.solve.options import BUILTIN, SolveOptions
from craftmesh.solve.problem import Supports, problem_of
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import Solution, TetMesh

# Largest Poisson's ratio, because displacement elements lock. On a penny crack at 45 degrees with five
# edges to its radius, K errs by up to 1.5 % of the largest K with a ratio of 0.49, by 14 % with 0.499.
MOST_POISSON = 0.49
# Memory of the solver: bytes per node of 4- and 10-node elements, and gigabytes for Python and its
# libraries. Measured with benchmarks/solve.py, rounded up.
_PER_NODE = {4: 4000, 10: 2000}
_AT_REST = 0.4
# Supports in a plane do not determine the strain normal to it: eigenvalues of their moments below this
# fraction of the largest are rounding.
_FLAT = 1e-10


def check_compressible(model: ElasticModel) -> None:
    """Raise CraftmeshError for a material with a Poisson's ratio over 0.49; the error names its grain."""
    ratio = poisson_ratios(model.stiffness())
    worst = int(np.argmax(ratio))
    if ratio[worst] <= MOST_POISSON + ROUNDING:
        return
    grain = int(model.grains[worst])
    phase = model.phase_of[grain]
    material = model.materials[phase]
    of_phase = "" if phase is None else f"{phase}="
    text = f"{of_phase}{material.kind}:{','.join(map(repr, material.constants))}"
    raise CraftmeshError(
        f"material {text} (grain {grain}): Poisson's ratio {ratio[worst]:.6g} is nearly incompressible; "
        f"the built-in solver takes at most {MOST_POISSON:g}; lower it, or solve by another program"
    )


def poisson_ratios(stiffness: np.ndarray) -> np.ndarray:
    """Return Poisson's ratios (g,) of stiffnesses (g, 6, 6), for crystals from their mean moduli.

    The bulk modulus is for uniform pressure (Reuss), the shear modulus the mean over all directions
    (Voigt).
    """
    mean = mean_moduli(stiffness)
    bulk, shear = mean.reuss_bulk, mean.voigt_shear
    return (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)


@typed
def solve_model(
    model: ElasticModel,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (frozen)
    progress: Callable[[float, str], None] = silent,
    field_of: FieldOf | None = None,
) -> tuple[dict[str, Solution], dict]:
    """Return the solutions of a model's combinations of load cases by name, and a report.

    The solution of an only load has the name "". Load cases are solved one by one, with one matrix if they
    have the same supports; combinations are sums of their fields. A sum in which lips would overlap is
    solved by itself, with contact. progress is called with the fraction done and a text. field_of: gives
    the fields if options.solver is not builtin: `field_of(model, name)` is called for each load case and
    returns node numbers (k,), displacements (k, 3) and their source. Raises CraftmeshError as `solve`, or
    for fields that do not fit the model, as `foreign_solution`.
    """
    if options.solver != BUILTIN:
        if field_of is None:
            raise CraftmeshError(
                f"solver is {options.solver}, which is not run here; pass field_of, or use builtin"
            )
        return foreign_solutions(model, options.solver, field_of)
    if not model.combinations:
        solution, report = solve(model, options, progress)
        return {"": solution}, report
    report = _checked(model, options, progress)
    last: Iteration | None = None
    fields, solutions, figures = {}, {}, {}
    for one in model.combinations:
        for case in one.factors:
            if case not in fields:
                last = _after(
                    last, replace(model, load=model.cases[case]), options, partial(_of, progress, case)
                )
                start = _start(model.mesh.points, last.problem.supports)
                fields[case] = last.solved(start, None, options.tolerance).displacement
        # the residual stress alone is a part of sums, which K by growth needs without contact
        own = replace(options, contact=False) if one.name == RESIDUAL else options
        last = _after(last, model.under(one), own, partial(_of, progress, one.name))
        solutions[one.name], figures[one.name] = _solution(model, last, one.sum_of(fields))
    return solutions, report | {"load_cases": figures}


def solve(
    model: ElasticModel,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (frozen)
    progress: Callable[[float, str], None] = silent,
) -> tuple[Solution, dict]:
    """Return the solution of a model and a report: unknowns, memory in GB, iterations, residual.

    By default elements are integrated as Abaqus and CalculiX integrate C3D4 and C3D10, so that all three
    find the same field, and lips (crack faces) that would overlap press on each other. If any do, the
    solution's record and the report have the numbers of contact. The same model gives the same bits. Raises
    CraftmeshError for a nearly incompressible material, a missing load, a body that is not held, inverted
    elements, more memory than the limit, and a residual that does not fall below the tolerance.
    """
    report = _checked(model, options, progress)
    iteration = _after(None, model, options, progress)
    start = _start(model.mesh.points, iteration.problem.supports)
    solution, figures = _solution(model, iteration, start)
    return solution, report | figures


def _of(progress: Callable[[float, str], None], name: str, share: float, text: str) -> None:
    progress(share, f"{name}: {text}")


def _after(
    last: Iteration | None,
    model: ElasticModel,
    options: SolveOptions,
    progress: Callable[[float, str], None],
) -> Iteration:
    """Return the iteration that solves a model.

    last: the iteration of another load on the same mesh, or None. Its elements are shared, and its matrix
    too if the supports are the same. Raises CraftmeshError as `problem_of`, for example for loose bodies.
    """
    rule = DECK_RULE if options.integration == "deck" else FULL_RULE
    problem = problem_of(model, rule, last.problem.elements if last else None)
    fixed = problem.supports.fixed
    alike = last is not None and np.array_equal(last.problem.supports.fixed, fixed)
    return Iteration(problem, options, progress, last if alike else None)


def _checked(
    model: ElasticModel, options: SolveOptions, progress: Callable[[float, str], None]
) -> dict[str, float]:
    """Return the number of unknowns and the memory in GB that a model needs.

    Raises CraftmeshError for a nearly incompressible material, and for more memory than the limit.
    """
    check_compressible(model)
    if model.lip_friction and not options.contact:
        raise CraftmeshError(
            f"lip_friction is {model.lip_friction:g}, but contact is false, so that lips overlap; set "
            "contact to true, or lip_friction to 0"
        )
    memory = memory_of(model.mesh)
    if memory > options.memory_limit:
        raise CraftmeshError(
            f"memory_limit: {model.mesh.points.size} unknowns need about {memory:.1f} GB, but the limit is "
            f"{options.memory_limit:g} GB; raise it, use longer edges, or another solver"
        )
    progress(0.0, f"{model.mesh.points.size} unknowns, about {memory:.1f} GB")
    return {"unknowns": model.mesh.points.size, "memory_gb": round(memory, 2)}


def _solution(model: ElasticModel, iteration: Iteration, start: np.ndarray) -> tuple[Solution, dict]:
    """Return the solution iterated from field `start` (n, 3), with contact of lips, and numbers about it.

    The numbers are iterations and residual and, with contact, those of `Contact.figures`.
    """
    options, problem = iteration.options, iteration.problem
    found = iteration.solved(start, None, options.tolerance)
    forces, contact_figures = None, {}
    if options.contact:
        pairs = lip_pairs(model.mesh)
        overlap = overlap_of(pairs, found.displacement)
        if overlap > least_overlap(found.displacement, options.tolerance):
            contact = with_contact(iteration, pairs, found.displacement, model.lip_friction)
            found, forces = contact.found, pairs.forces(contact.found.push, problem.forces.shape)
            contact_figures = contact.figures() | {"overlap_without_contact": overlap}
    _, reactions, residual = problem.balance(found.displacement, forces)
    if not residual <= options.tolerance:
        raise refused(residual, iteration.count, options)
    figures = {"iterations": iteration.count, "residual": residual} | contact_figures
    return Solution(found.displacement, reactions, {"solver": BUILTIN, **figures}, forces), figures


def memory_of(mesh: TetMesh) -> float:
    """Return the estimated memory in gigabytes that the solver needs for a mesh."""
    return _AT_REST + 1e-9 * _PER_NODE[mesh.tets.shape[1]] * len(mesh.points)


def _start(points: np.ndarray, supports: Supports) -> np.ndarray:
    """Return the field (n, 3) of uniform strain that fits the supports best, as the iteration's start.

    Prescribed components get exactly their values. Sums use einsum, because the last bits of BLAS sums
    depend on the number of threads.
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
