"""The tetrahedra of all grains on common nodes, for changes that neighbours have to see alike."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from craftmesh.sizing.length_field import LocalSizing
from craftmesh.surface.connectivity import lowest_equal_point
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.optimise_tets import Step, optimise_tets
from craftmesh.types import GrainTets, Surface


@dataclass(frozen=True)
class Model:
    """All grains' tets on common nodes: the surface's points, then the interior points of each grain."""

    surface: Surface
    grain_tets: Sequence[GrainTets]

    @cached_property
    def points(self) -> np.ndarray:
        """(n, 3) all nodes."""
        return np.concatenate([self.surface.points, *(one.interior for one in self.grain_tets)])

    @cached_property
    def tets(self) -> np.ndarray:
        """(m, 4) the tets of all grains, one grain after another."""
        first, blocks = len(self.surface.points), []
        for one in self.grain_tets:
            ids = np.concatenate([one.nodes, first + np.arange(len(one.interior))])
            blocks.append(ids[one.tets])
            first += len(one.interior)
        return np.concatenate(blocks)

    @cached_property
    def grain(self) -> np.ndarray:
        """(m,) the grain of each tet."""
        count = [len(one.tets) for one in self.grain_tets]
        return np.repeat([one.grain for one in self.grain_tets], count)

    def moved(self, points: np.ndarray) -> "Model":
        """Return the model with its nodes at `points`; surface points that are equal move together."""
        old = self.surface.points
        on_surface = points[: len(old)][lowest_equal_point(old)]
        starts = np.cumsum([len(old), *(len(one.interior) for one in self.grain_tets)])
        inner = [points[a : a + len(one.interior)] for a, one in zip(starts, self.grain_tets)]
        return Model(
            replace(self.surface, points=on_surface),
            [replace(one, interior=interior) for one, interior in zip(self.grain_tets, inner)],
        )


def regrouped(
    model: Model, rows: np.ndarray, points: np.ndarray, tets: np.ndarray, grain: np.ndarray
) -> Model:
    """Return the model with the tets (k, 4) of grains (k,) in place of its tets `rows`.

    points (n, 3): the model's, then those that are new; interior points that no tet uses go.
    """
    first, result = len(model.surface.points), list(model.grain_tets)
    stays = np.ones(len(model.tets), bool)
    stays[rows] = False
    for i, one in enumerate(result):
        own = model.grain == one.grain
        if (own & ~stays).any():
            corners = np.concatenate([model.tets[own & stays], tets[grain == one.grain]])
            inner = np.unique(corners[corners >= first])
            ids = np.concatenate([one.nodes, inner])
            local = np.searchsorted(ids, corners)
            result[i] = GrainTets(one.grain, one.nodes, points[inner], local)
    return Model(model.surface, result)


def optimised_inside(model: Model, steps: Sequence[Step]) -> Model:
    """Return the model with the steps done in each grain; target lengths are the surface's own."""
    result = []
    for one, surface in zip(model.grain_tets, grain_surfaces(model.surface)):
        points = np.concatenate([model.surface.points[one.nodes], one.interior])
        internal = np.searchsorted(one.nodes, surface.nodes[surface.facets[surface.internal]])
        size = LocalSizing(surface.points, surface.facets).at(points)
        points, tets, _ = optimise_tets(points, one.tets, len(one.nodes), internal, size, steps)
        result.append(GrainTets(one.grain, one.nodes, points[len(one.nodes) :], tets))
    return Model(model.surface, result)
