"""The elements of a model as the kernels take them, and what they ask of their nodes."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import shape_slopes, tet_rule
from craftmesh.solve.kernels.elements import internal_forces, strain_forces


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

    def forces(self, displacement: np.ndarray) -> np.ndarray:
        """Return the forces (n, 3) that hold the elements in this displacement (n, 3)."""
        return internal_forces(*self.tables, displacement)

    def strain_forces(self, strain: np.ndarray) -> np.ndarray:
        """Return the forces (n, 3) that hold the elements in uniform strains (g, 6) by part."""
        return strain_forces(*self.tables, strain)


def elements_of(model: ElasticModel, rule: int) -> Elements:
    """Return the elements of a model; those of 4 nodes need no more than one point."""
    mesh = model.mesh
    part = np.searchsorted(model.grains, mesh.grain)
    rule = 1 if mesh.tets.shape[1] == 4 else rule
    return Elements(mesh.points, mesh.tets, part, model.stiffness(), rule)
