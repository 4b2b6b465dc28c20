"""A model's elements, supports and load, and the balance of a field."""

from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.eigenstrains import components
from craftmesh.mechanics.load import Load, nodal_forces
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.rigid_body_supports import free_motions, supported_bodies
from craftmesh.mesh.integration import DECK_RULE, shape_slopes, shape_values, smallest_jacobians, tet_rule
from craftmesh.solve.kernels.elements import internal_forces
from craftmesh.types import TetMesh


@dataclass(frozen=True, eq=False)
class Elements:
    """The elements of a body, for the kernels.

    points (n, 3); tets (m, k), k = 4 or 10; part (m,): row of each element in `stiffness` (g, 6, 6), which
    is in sample axes; rule: the number of integration points of an element, 1, 4 or 14.
    """

    points: np.ndarray
    tets: np.ndarray
    part: np.ndarray
    stiffness: np.ndarray
    rule: int

    @property
    def tables(self) -> tuple[np.ndarray, ...]:
        """The kernels' arguments: the arrays, then slopes (q, k, 3) and weights (q,) of the rule."""
        places, weights = tet_rule(self.rule)
        slopes = shape_slopes(places, self.tets.shape[1])
        return self.points, self.tets, self.part, self.stiffness, slopes, weights

    def forces(
        self,
        displacement: np.ndarray,
        free: np.ndarray | None = None,
        temperature: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return the nodal forces (n, 3) that hold the elements at a displacement (n, 3).

        free (g, 6): stress-free strains by part, with engineering shears; None: 0. temperature (n,): their
        factor at the nodes; None: 1.
        """
        free = np.zeros((len(self.stiffness), 6)) if free is None else free
        temperature = np.ones(len(self.points)) if temperature is None else temperature
        values = shape_values(tet_rule(self.rule)[0], self.tets.shape[1])
        return internal_forces(*self.tables, displacement, free, values, temperature)


def elements_of(model: ElasticModel, rule: int) -> Elements:
    """Return the elements of a model; 4-node elements have one integration point, whatever `rule` is."""
    mesh = model.mesh
    part = np.searchsorted(model.grains, mesh.grain)
    rule = 1 if mesh.tets.shape[1] == 4 else rule
    return Elements(mesh.points, mesh.tets, part, model.stiffness(), rule)


@dataclass(frozen=True, eq=False)
class Supports:
    """Prescribed displacements: fixed (n, 3), a mask of components, and displacement (n, 3), their values.

    Values of components that are not prescribed are 0.
    """

    fixed: np.ndarray
    displacement: np.ndarray


def supports_of(load: Load, mesh: TetMesh) -> Supports:
    """Return the supports of a load; nodes of no element are held too.

    Raises CraftmeshError if two values are prescribed for one displacement component, and if a separate
    piece of the body can move as a whole.
    """
    fixed = np.zeros(mesh.points.shape, bool)
    displacement = np.zeros(mesh.points.shape)
    for part in (*load.held, *load.moved):
        before = displacement[part.nodes, part.axis]
        clash = fixed[part.nodes, part.axis] & (before != part.displacement)
        if clash.any():
            raise CraftmeshError(
                f"load: node {part.nodes[clash][0] + 1} is prescribed to move along {'xyz'[part.axis]} by "
                f"{before[clash][0]:g} and by another value; prescribe only one"
            )
        fixed[part.nodes, part.axis] = True
        displacement[part.nodes, part.axis] = part.displacement
    _check_held(mesh, fixed)
    idle = np.ones(len(fixed), bool)
    idle[mesh.tets] = False
    fixed[idle] = True
    return Supports(fixed, displacement)


def _check_held(mesh: TetMesh, fixed: np.ndarray) -> None:
    """Raise CraftmeshError if a piece of the body (elements that nodes connect) can move as a whole."""
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
    """Elements, supports, and the applied forces (n, 3) at the nodes, including forces of eigenstrains."""

    elements: Elements
    supports: Supports
    forces: np.ndarray

    def balance(
        self, displacement: np.ndarray, contact: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Return the forces out of balance (n, 3), the reactions (n, 3) and the residual of a field (n, 3).

        The residual is the norm of the forces out of balance over the norm of all reactions and applied
        forces; it is not divided if these are 0. contact (n, 3): forces of touching lips on each
        other; they are in the balance, but do not count as applied forces in the norm.
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
        """Return the norm of all reactions (n, 3) and applied forces."""
        return float(np.sqrt((reactions**2).sum() + (self.forces**2).sum()))


def problem_of(model: ElasticModel, rule: int = DECK_RULE, elements: Elements | None = None) -> Problem:
    """Return the problem of a model; rule: 4 or 14 integration points of its 10-node elements.

    elements: the model's elements, if already made for another load; they are then not checked again.
    Raises CraftmeshError for a model without a load, a body that is not held, and elements that are
    inverted or flat.
    """
    if model.load is None:
        raise CraftmeshError("load is none; give a strain, a stress, lip_pressure or eigenstrain to solve")
    if elements is None:
        bad = np.flatnonzero(~(smallest_jacobians(model.mesh.points, model.mesh.tets) > 0))
        if len(bad):
            raise CraftmeshError(
                f"solve: {len(bad)} elements are inverted or flat (the first is element {bad[0] + 1} of "
                f"grain {model.mesh.grain[bad[0]]}); repair the mesh (see craftmesh check)"
            )
        elements = elements_of(model, rule)
    supports, forces = supports_of(model.load, model.mesh), nodal_forces(model.load.pulled, model.mesh)
    strain = model.eigenstrain()
    if strain.any():
        forces -= elements.forces(np.zeros_like(forces), components(strain), model.temperature)
    return Problem(elements, supports, forces)
