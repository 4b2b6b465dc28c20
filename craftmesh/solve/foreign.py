"""Fields of displacements that other programs found, held against the model before they are taken."""

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.model import ElasticModel
from craftmesh.solve.problem import Problem, problem_of
from craftmesh.types import Solution

# Six digits, as in .frd, leave 3e-4 with 43 thousand unknowns, and more with finer meshes; a field of
# another load or material leaves 0.3 and more.
_LARGEST_RESIDUAL = 0.1
# A support's displacement comes back to six digits of the largest one.
_SUPPORT = 1e-4


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
    field = _in_order(numbers, displacement, len(model.mesh.points), source)
    _check_supports(problem, field, source)
    _, reactions, residual = problem.balance(field, contact)
    if not residual <= _LARGEST_RESIDUAL:
        raise CraftmeshError(
            f"{source}: the field leaves {residual:.2g} of the forces out of balance, expected at most "
            f"{_LARGEST_RESIDUAL:g}; take the field of this deck, with the same mesh, materials and load, "
            "or a direct solver"
        )
    record: dict[str, str | int | float] = {"solver": solver, "residual": residual}
    return Solution(field, reactions, record, contact), {"unknowns": field.size} | record


def _in_order(numbers: np.ndarray, displacement: np.ndarray, count: int, source: str) -> np.ndarray:
    """Return the values (count, 3) by node."""
    seen = np.bincount(numbers[(numbers > 0) & (numbers <= count)], minlength=count + 1)[1:]
    for wrong, what in (
        (numbers[(numbers < 1) | (numbers > count)], "is no node of the deck"),
        (np.flatnonzero(seen > 1) + 1, "is there twice"),
        (np.flatnonzero(seen == 0) + 1, "is missing"),
        (numbers[~np.isfinite(displacement).all(axis=1)], "has a value that is not finite"),
    ):
        if len(wrong):
            raise CraftmeshError(
                f"{source}: node {wrong[0]} {what} ({len(wrong)} such); expected the nodes 1 to {count}, "
                "each once"
            )
    field = np.empty((count, 3))
    field[numbers - 1] = displacement
    return field


def _check_supports(problem: Problem, field: np.ndarray, source: str) -> None:
    supports = problem.supports
    off = np.where(supports.fixed, np.abs(field - supports.displacement), 0.0)
    if off.max(initial=0.0) > _SUPPORT * np.abs(field).max(initial=0.0):
        node, axis = np.unravel_index(off.argmax(), off.shape)
        raise CraftmeshError(
            f"{source}: node {node + 1} moves along {'xyz'[axis]} by {field[node, axis]:.6g}, the load "
            f"prescribes {supports.displacement[node, axis]:.6g}; take the field of this deck"
        )
