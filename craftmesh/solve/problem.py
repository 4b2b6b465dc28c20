"""A model's elements, supports and load, how far a field is from balance, and fields of other programs."""

from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.eigenstrains import components
from craftmesh.mechanics.holding import free_motions, supported_bodies
from craftmesh.mechanics.load import Load, nodal_forces
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import DECK_RULE, shape_slopes, smallest_jacobians, tet_rule
from craftmesh.solve.kernels.elements import internal_forces
from craftmesh.surface.side_data import UNITS, power_told
from craftmesh.types import Solution, TetMesh

# Six digits, as in .frd, leave 3e-4 with 43 thousand unknowns, and more with finer meshes; a field of
# another load or material leaves 0.3 and more.
_LARGEST_RESIDUAL = 0.1
# A support's displacement comes back to six digits of the largest one.
_SUPPORT = 1e-4


@dataclass(frozen=True, eq=False)
class Elements:
    """points (n, 3); tets (m, k), k = 4 or 10; part (m,): row in `stiffness` (g, 6, 6), sample axes.

    rule: the number of points at which they are integrated, 1, 4 or 14.
    """

    points: np.ndarray
    tets: np.ndarray
    part: np.ndarray
    stiffness: np.ndarray
    rule: int

    @property
    def tables(self) -> tuple[np.ndarray, ...]:
        """All of it as the kernels take it: slopes (q, k, 3) and weights (q,) of the rule come last."""
        places, weights = tet_rule(self.rule)
        slopes = shape_slopes(places, self.tets.shape[1])
        return self.points, self.tets, self.part, self.stiffness, slopes, weights

    def forces(self, displacement: np.ndarray, free: np.ndarray | None = None) -> np.ndarray:
        """Return the forces (n, 3) that hold the elements in this displacement (n, 3).

        free (g, 6): the strains by part that take no force, none by default.
        """
        free = np.zeros((len(self.stiffness), 6)) if free is None else free
        return internal_forces(*self.tables, displacement, free)


def elements_of(model: ElasticModel, rule: int) -> Elements:
    """Return the elements of a model; those of 4 nodes need no more than one point."""
    mesh = model.mesh
    part = np.searchsorted(model.grains, mesh.grain)
    rule = 1 if mesh.tets.shape[1] == 4 else rule
    return Elements(mesh.points, mesh.tets, part, model.stiffness(), rule)


@dataclass(frozen=True, eq=False)
class Supports:
    """fixed (n, 3) bool: prescribed components; displacement (n, 3): their values, 0 elsewhere."""

    fixed: np.ndarray
    displacement: np.ndarray


def supports_of(load: Load, mesh: TetMesh) -> Supports:
    """Return the supports of a load; nodes without an element are held too.

    Raises CraftmeshError where two values are prescribed for one displacement, and where a piece of the
    body can move as a whole.
    """
    fixed = np.zeros(mesh.points.shape, bool)
    displacement = np.zeros(mesh.points.shape)
    for part in (*load.held, *load.moved):
        before = displacement[part.nodes, part.axis]
        clash = fixed[part.nodes, part.axis] & (before != part.displacement)
        if clash.any():
            raise CraftmeshError(
                f"load: node {part.nodes[clash][0] + 1} is to move along {'xyz'[part.axis]} by "
                f"{before[clash][0]:g} and by another value too; prescribe one"
            )
        fixed[part.nodes, part.axis] = True
        displacement[part.nodes, part.axis] = part.displacement
    _check_held(mesh, fixed)
    idle = np.ones(len(fixed), bool)
    idle[mesh.tets] = False
    fixed[idle] = True
    return Supports(fixed, displacement)


def _check_held(mesh: TetMesh, fixed: np.ndarray) -> None:
    """Refuse a piece of the body (elements joined by nodes) that the supports leave a rigid motion."""
    for body in supported_bodies(mesh, [(np.flatnonzero(fixed[:, axis]), axis) for axis in range(3)]):
        if len(free_motions(body.rows)):
            first = np.argmax(body.elements)
            place = ", ".join(f"{x:.4g}" for x in mesh.points[mesh.tets[first, 0]])
            raise CraftmeshError(
                f"load: a piece of {body.elements.sum()} elements at ({place}), grain {mesh.grain[first]}, "
                "is not held against moving as a whole; hold it (sides, axis), or end the growth before "
                "the crack severs the body"
            )


@dataclass(frozen=True, eq=False)
class Problem:
    """elements, supports, and the forces (n, 3) that act at the nodes, those of eigenstrains too."""

    elements: Elements
    supports: Supports
    forces: np.ndarray

    def balance(
        self, displacement: np.ndarray, contact: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Return of a field (n, 3): forces out of balance (n, 3), reactions (n, 3), and the residual.

        The residual is the length of all forces out of balance over that of all reactions and forces that
        act; 0 where nothing is loaded. contact (n, 3): forces by which lips that touch push each other
        apart, which do not count as forces that act.
        """
        left = self.forces - self.elements.forces(displacement)
        if contact is not None:
            left += contact
        fixed = self.supports.fixed
        reactions = np.where(fixed, -left, 0.0)
        left[fixed] = 0.0
        size = self.size(reactions)
        out = np.sqrt((left**2).sum())
        return left, reactions, float(out / size) if size > 0 else float(out)

    def size(self, reactions: np.ndarray) -> float:
        """Return the length of all reactions (n, 3) and forces that act."""
        return float(np.sqrt((reactions**2).sum() + (self.forces**2).sum()))


def problem_of(model: ElasticModel, rule: int = DECK_RULE, elements: Elements | None = None) -> Problem:
    """Return the problem of a model whose 10-node elements are integrated at 4 or 14 points.

    elements: those of the model, where another load has made them. Raises CraftmeshError for a model
    without a load, a body that is not held, and elements that are turned over.
    """
    if model.load is None:
        raise CraftmeshError("load: none; a solver needs a strain, a stress, lip_pressure or eigenstrain")
    if elements is None:
        bad = np.flatnonzero(~(smallest_jacobians(model.mesh.points, model.mesh.tets) > 0))
        if len(bad):
            raise CraftmeshError(
                f"solve: {len(bad)} elements are turned over or flat (the first is element {bad[0] + 1} of "
                f"grain {model.mesh.grain[bad[0]]}); mend the mesh (craftmesh check says more)"
            )
        elements = elements_of(model, rule)
    supports, forces = supports_of(model.load, model.mesh), nodal_forces(model.load.pulled, model.mesh)
    strain = model.eigenstrain()
    if strain.any():
        forces -= elements.forces(np.zeros_like(forces), components(strain))
    return Problem(elements, supports, forces)


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
