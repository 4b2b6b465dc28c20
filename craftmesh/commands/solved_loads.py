"""The loads that a solution.npz is of, each with its model and its field, and their rows in one table."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError, existing
from craftmesh.growth.options import check_cycle
from craftmesh.io.front_csv import LOAD_CASE
from craftmesh.io.stage_npz import read_solutions
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import DECK_RULE, FULL_RULE
from craftmesh.solve.options import EXTERNAL
from craftmesh.solve.problem import foreign_solution, problem_of
from craftmesh.types import Solution

# A field of the same model is as far out of balance as before, but for rounding; without the quarter points
# of a penny it was 8e-2.
MORE, ROUNDING = 10.0, 1e-10


def solved_loads(
    model: ElasticModel, path: Path, cycle: Sequence[str]
) -> dict[str, tuple[ElasticModel, Solution]]:
    """Return the model under each load that a file has, and the solution, by name, "" of a single load.

    Those of the cycle come first. Raises CraftmeshError for fields of other meshes, loads or names.
    """
    solutions = read_solutions(existing(path))
    models = {one.name: model.under(one) for one in model.combinations} or {"": model}
    if solutions.keys() != models.keys():
        asked, there = (", ".join(filter(None, names)) or "one load" for names in (models, solutions))
        raise CraftmeshError(
            f"{path}: has the fields of {there}, and the options are for {asked}; give those with which it "
            "was solved (faces, combine)"
        )
    check_cycle(cycle, list(models))
    for name, solution in solutions.items():
        if solution.history:
            raise CraftmeshError(
                f"{path}: has the end of a load in steps, and K is of elastic fields: solve with builtin"
            )
        if solution.displacement.shape != model.mesh.points.shape:
            raise CraftmeshError(
                f"{path}: has {len(solution.displacement)} nodes, the mesh {len(model.mesh.points)}; give "
                "the solution of this mesh, and the same element"
            )
        if model.load is not None:
            _check_field(models[name], solution, str(path))
    return {name: (models[name], solutions[name]) for name in dict.fromkeys([*cycle, *models])}


def by_load(columns: Mapping[str, Mapping[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the rows of loads one after the other, named in the column LOAD_CASE.

    What only the first has is no number in the others' rows, or no text.
    """
    first, *_ = columns.values()
    count = len(first["node"])
    joined = {LOAD_CASE: np.repeat(np.array(list(columns), object), count)}
    for key, own in first.items():
        none = np.full(own.shape, "", object) if own.dtype == object else np.full(own.shape, np.nan)
        joined[key] = np.concatenate([part.get(key, none) for part in columns.values()])
    return joined


def _check_field(model: ElasticModel, solution: Solution, source: str) -> None:
    """Raise CraftmeshError for a field that is not in balance as it was when it was found."""
    numbers = np.arange(1, len(solution.displacement) + 1)
    foreign_solution(model, numbers, solution.displacement, EXTERNAL, source, solution.contact)
    recorded = float(solution.record.get("residual", np.inf))
    residual = min(
        problem_of(model, rule).balance(solution.displacement, solution.contact)[2]
        for rule in (DECK_RULE, FULL_RULE)
    )
    if residual > MORE * max(recorded, ROUNDING):
        raise CraftmeshError(
            f"{source}: the field leaves {residual:.1e} of the forces out of balance here, and left "
            f"{recorded:.1e} when it was found; give the options with which it was solved (quarter_points?)"
        )
