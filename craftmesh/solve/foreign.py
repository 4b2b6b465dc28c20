"""Fields that other programs found or that come from files, held against their model."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import FULL_RULE
from craftmesh.solve.options import EXTERNAL
from craftmesh.solve.problem import Problem, problem_of
from craftmesh.surface.side_data import UNITS, power_told
from craftmesh.types import Solution

# Six digits, as in .frd, leave 3e-4 with 43 thousand unknowns, and more with finer meshes; a field of
# another load or material leaves 0.3 and more.
_LARGEST_RESIDUAL = 0.1
# A support's displacement comes back to six digits of the largest one.
_SUPPORT = 1e-4
# A field of the same model is as far out of balance as before, but for rounding; without the quarter points
# of a penny it was 8e-2.
_RESIDUAL_FACTOR, _ROUNDING = 10.0, 1e-10

# What a program finds for a model and its load's name: numbers of nodes (k,), displacements (k, 3), source.
FieldOf = Callable[[ElasticModel, str], tuple[np.ndarray, np.ndarray, str]]


def foreign_solutions(
    model: ElasticModel, solver: str, field_of: FieldOf
) -> tuple[dict[str, Solution], dict]:
    """Return the solutions that a program finds for a model, by name, and a report of each.

    Of combinations it finds the load cases; errors are those of `foreign_solution`.
    """
    if not model.combinations:
        numbers, displacement, source = field_of(model, "")
        solution, report = foreign_solution(model, numbers, displacement, solver, source)
        return {"": solution}, report
    fields = {}
    for case, load in model.cases.items():
        loaded = replace(model, load=load, cases={})
        numbers, displacement, source = field_of(loaded, case)
        fields[case] = foreign_solution(loaded, numbers, displacement, solver, source)[0].displacement
    numbers = np.arange(1, len(model.mesh.points) + 1)
    solutions, figures = {}, {}
    for one in model.combinations:
        found = foreign_solution(model.under(one), numbers, one.sum_of(fields), solver, one.name)
        solutions[one.name], figures[one.name] = found
    return solutions, {"load_cases": figures}


def check_solutions(model: ElasticModel, solutions: Mapping[str, Solution], source: str) -> None:
    """Raise CraftmeshError unless solutions by name are elastic fields of the model under its loads.

    source: the file that they come from, for errors. A model without a load takes any field of its mesh.
    """
    models = model.by_load()
    if solutions.keys() != models.keys():
        asked, there = (", ".join(filter(None, names)) or "one load" for names in (models, solutions))
        raise CraftmeshError(
            f"{source}: has the fields of {there}, and the options are for {asked}; give those "
            "with which it was solved (faces, combine)"
        )
    for name, solution in solutions.items():
        if solution.history:
            raise CraftmeshError(
                f"{source}: has the end of a load in steps, and K is of elastic fields: solve with builtin"
            )
        if solution.displacement.shape != model.mesh.points.shape:
            raise CraftmeshError(
                f"{source}: has {len(solution.displacement)} nodes, the mesh {len(model.mesh.points)}; "
                "give the solution of this mesh, and the same element"
            )
        if model.load is not None:
            _check_balance(models[name], solution, source)


def _check_balance(model: ElasticModel, solution: Solution, source: str) -> None:
    """Raise CraftmeshError if a field's residual in the model is larger than when it was solved."""
    field, numbers = solution.displacement, np.arange(1, len(solution.displacement) + 1)
    _, found = foreign_solution(model, numbers, field, EXTERNAL, source, solution.contact)
    recorded = float(solution.record.get("residual", np.inf))
    residual, most = found["residual"], _RESIDUAL_FACTOR * max(recorded, _ROUNDING)
    if residual > most:  # of an integration in full
        residual = min(residual, problem_of(model, FULL_RULE).balance(field, solution.contact)[2])
    if residual > most:
        raise CraftmeshError(
            f"{source}: the field leaves {residual:.1e} of the forces out of balance here, and left "
            f"{recorded:.1e} when it was found; give the options with which it was solved (quarter_points?)"
        )


def foreign_solution(
    model: ElasticModel,
    numbers: np.ndarray,
    displacement: np.ndarray,
    solver: str,
    source: str,
    contact: np.ndarray | None = None,
) -> tuple[Solution, dict]:
    """Return the solution that a program found, and a report.

    numbers (k,): the deck's numbers of nodes; displacement (k, 3) in the same order; source: what they
    come from, for errors; contact (n, 3): as in `Solution`, by the mesh's nodes. Raises CraftmeshError for
    nodes that are missing, there twice or unknown, values that are not finite, and a field that does not
    keep the supports or is far from balance: one of another mesh, load or material.
    """
    problem = problem_of(model)
    field = in_order(numbers, displacement, len(model.mesh.points), source)
    fault, reactions, residual = _checked(problem, field, contact)
    if fault:
        powers = [sign * power for power in UNITS for sign in (1, -1)]
        fits = (power for power in powers if not _checked(problem, field / 10.0**power, contact)[0])
        unit = next(fits, 0)
        said = f"; its values are those of the deck{power_told(unit)}" if unit else ""
        raise CraftmeshError(f"{source}: {fault}{said}")
    record: dict[str, str | int | float] = {"solver": solver, "residual": residual}
    return Solution(field, reactions, record, contact), {"unknowns": field.size} | record


def in_order(numbers: np.ndarray, values: np.ndarray, count: int, source: str) -> np.ndarray:
    """Return the values (count, c) by node; raises CraftmeshError as `foreign_solution`."""
    seen = np.bincount(numbers[(numbers > 0) & (numbers <= count)], minlength=count + 1)[1:]
    for wrong, what in (
        (numbers[(numbers < 1) | (numbers > count)], "is no node of the deck"),
        (np.flatnonzero(seen > 1) + 1, "is there twice"),
        (np.flatnonzero(seen == 0) + 1, "is missing"),
        (numbers[~np.isfinite(values).all(axis=1)], "has a value that is not finite"),
    ):
        if len(wrong):
            raise CraftmeshError(
                f"{source}: node {wrong[0]} {what} ({len(wrong)} such); expected the nodes 1 to {count}, "
                "each once"
            )
    field = np.empty((count, values.shape[1]))
    field[numbers - 1] = values
    return field


def _checked(
    problem: Problem, field: np.ndarray, contact: np.ndarray | None
) -> tuple[str, np.ndarray, float]:
    """Return the fault of a field (n, 3) in words, "" for none, the reactions (n, 3) and the residual.

    The fault is a support that the field does not keep, whose balance is not computed, or its residual.
    """
    supports = problem.supports
    off = np.where(supports.fixed, np.abs(field - supports.displacement), 0.0)
    if off.max(initial=0.0) > _SUPPORT * np.abs(field).max(initial=0.0):
        node, axis = np.unravel_index(off.argmax(), off.shape)
        fault = (
            f"node {node + 1} moves along {'xyz'[axis]} by {field[node, axis]:.6g}, the load "
            f"prescribes {supports.displacement[node, axis]:.6g}; take the field of this deck"
        )
        return fault, np.zeros_like(field), np.inf
    _, reactions, residual = problem.balance(field, contact)
    if residual <= _LARGEST_RESIDUAL:
        return "", reactions, residual
    fault = (
        f"the field leaves {residual:.2g} of the forces out of balance, expected at most "
        f"{_LARGEST_RESIDUAL:g}; take the field of this deck, with the same mesh, materials and load, "
        "or a direct solver"
    )
    return fault, reactions, residual
