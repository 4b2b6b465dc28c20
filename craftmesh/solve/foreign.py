"""Fields from other programs or from files, checked against their model."""

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

# Largest residual (forces out of balance over reactions and loads) of an accepted field. Six digits, as in
# .frd, leave 3e-4 with 43 thousand unknowns, and more with finer meshes; a field of another load or
# material leaves 0.3 and more.
_LARGEST_RESIDUAL = 0.1
# Largest deviation from a prescribed displacement, over the largest displacement: files have six digits.
_SUPPORT = 1e-4
# Largest ratio of the residual to the recorded one, and smallest recorded residual that counts. A field of
# the same model differs by rounding; that of a penny crack, without its quarter points, left 8e-2.
_RESIDUAL_FACTOR, _ROUNDING = 10.0, 1e-10

# Function of a model and its load's name that returns node numbers (k,), displacements (k, 3) and source.
FieldOf = Callable[[ElasticModel, str], tuple[np.ndarray, np.ndarray, str]]


def foreign_solutions(
    model: ElasticModel, solver: str, field_of: FieldOf
) -> tuple[dict[str, Solution], dict]:
    """Return a model's solutions by load name, from fields of another program, and a report.

    solver: the program's name; field_of: called for the only load or, if the model has combinations, for
    each load case. A combination's field is the weighted sum of its cases' fields. The report is that of
    the only solution, or has the reports of the combinations by name under "load_cases". Raises
    CraftmeshError for fields that do not fit the model, as `foreign_solution`.
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

    source: the file that they come from, for errors. For a model without a load, only the load's name, the
    number of nodes and the absence of a load history are checked.
    """
    models = model.by_load()
    if solutions.keys() != models.keys():
        asked, there = (", ".join(filter(None, names)) or "one load" for names in (models, solutions))
        raise CraftmeshError(
            f"{source}: has the fields of {there}, but the options are for {asked}; give the "
            "options with which it was solved (faces, combine)"
        )
    for name, solution in solutions.items():
        if solution.history:
            raise CraftmeshError(
                f"{source}: has the end of a load in steps, but K needs elastic fields: solve with builtin"
            )
        if solution.displacement.shape != model.mesh.points.shape:
            raise CraftmeshError(
                f"{source}: has {len(solution.displacement)} nodes, but the mesh {len(model.mesh.points)}; "
                "give the solution of this mesh, with the same element"
            )
        if model.load is not None:
            _check_balance(models[name], solution, source)


def _check_balance(model: ElasticModel, solution: Solution, source: str) -> None:
    """Raise CraftmeshError if a field's residual in the model is over 10 times that in its record.

    The smaller of the residuals with both integration rules counts.
    """
    field, numbers = solution.displacement, np.arange(1, len(solution.displacement) + 1)
    _, found = foreign_solution(model, numbers, field, EXTERNAL, source, solution.contact)
    recorded = float(solution.record.get("residual", np.inf))
    residual, most = found["residual"], _RESIDUAL_FACTOR * max(recorded, _ROUNDING)
    if residual > most:  # the field may come from full integration
        residual = min(residual, problem_of(model, FULL_RULE).balance(field, solution.contact)[2])
    if residual > most:
        raise CraftmeshError(
            f"{source}: the field leaves {residual:.1e} of this model's forces out of balance, but left "
            f"{recorded:.1e} when solved; give the options with which it was solved, such as quarter_points"
        )


def foreign_solution(
    model: ElasticModel,
    numbers: np.ndarray,
    displacement: np.ndarray,
    solver: str,
    source: str,
    contact: np.ndarray | None = None,
) -> tuple[Solution, dict]:
    """Return the solution of another program's field, and a report: unknowns, solver and residual.

    numbers (k,): node numbers of the deck, from 1; displacement (k, 3) in the same order; solver: the
    program's name; source: the field's file, for errors; contact (n, 3): forces of touching lips on each
    other. Raises CraftmeshError for missing, duplicate or unknown nodes, values that are not
    finite, and a field that does not keep the supports or has a residual over 0.1, as a field of another
    mesh, load or material has.
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
    """Return values (count, c) in the order of the nodes; numbers (count,): the node of each row, from 1.

    Raises CraftmeshError for missing, duplicate or unknown nodes, and values that are not finite.
    """
    seen = np.bincount(numbers[(numbers > 0) & (numbers <= count)], minlength=count + 1)[1:]
    for wrong, what in (
        (numbers[(numbers < 1) | (numbers > count)], "is no node of the deck"),
        (np.flatnonzero(seen > 1) + 1, "is duplicate"),
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
    """Return the fault of a field (n, 3) as text, its reactions (n, 3) and its residual.

    The fault is a violated support (reactions are then 0 and the residual inf), or a residual above
    _LARGEST_RESIDUAL; it is "" for a good field.
    """
    supports = problem.supports
    off = np.where(supports.fixed, np.abs(field - supports.displacement), 0.0)
    if off.max(initial=0.0) > _SUPPORT * np.abs(field).max(initial=0.0):
        node, axis = np.unravel_index(off.argmax(), off.shape)
        fault = (
            f"node {node + 1} moves along {'xyz'[axis]} by {field[node, axis]:.6g}, but the load "
            f"prescribes {supports.displacement[node, axis]:.6g}; use the field of this deck"
        )
        return fault, np.zeros_like(field), np.inf
    _, reactions, residual = problem.balance(field, contact)
    if residual <= _LARGEST_RESIDUAL:
        return "", reactions, residual
    fault = (
        f"the field leaves {residual:.2g} of the forces out of balance, expected at most "
        f"{_LARGEST_RESIDUAL:g}; use the field of this deck, with the same mesh, materials and load, "
        "or solve it by a direct solver"
    )
    return fault, reactions, residual
