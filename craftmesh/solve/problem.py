"""A model's elements, supports and load, and how far a field is from balance."""

from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.eigenstrains import components
from craftmesh.mechanics.holding import free_motions, supported_bodies
from craftmesh.mechanics.load import Load, nodal_forces
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import DECK_RULE, shape_slopes, smallest_jacobians, tet_rule
from craftmesh.solve.kernels.elements import internal_forces
from craftmesh.types import TetMesh


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
