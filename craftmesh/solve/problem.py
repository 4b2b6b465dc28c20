"""A model's load on its elements, and how far a field of displacements is from balance."""

from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.eigenstrains import components
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.tractions import nodal_forces
from craftmesh.mesh.kernels.tet_jacobians import smallest_jacobians
from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.solve.elements import Elements, elements_of
from craftmesh.solve.supports import Supports, supports_of
from craftmesh.types import TetMesh

# Points at which Abaqus and CalculiX integrate a C3D10.
DECK_RULE = 4


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
        _check_elements(model.mesh)
        elements = elements_of(model, rule)
    supports, forces = supports_of(model.load, model.mesh), nodal_forces(model.load.pulled, model.mesh)
    strain = model.eigenstrain()
    if strain.any():
        forces += elements.strain_forces(components(strain))
    return Problem(elements, supports, forces)


def _check_elements(mesh: TetMesh) -> None:
    check = tet_volumes if mesh.tets.shape[1] == 4 else smallest_jacobians
    bad = np.flatnonzero(~(check(mesh.points, mesh.tets) > 0))
    if len(bad):
        raise CraftmeshError(
            f"solve: {len(bad)} elements are turned over or flat (the first is element {bad[0] + 1} of "
            f"grain {mesh.grain[bad[0]]}); mend the mesh (craftmesh check says more)"
        )
