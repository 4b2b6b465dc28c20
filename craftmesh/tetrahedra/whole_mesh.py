"""The tetrahedra of all grains on common nodes, for changes that affect neighbouring grains."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from craftmesh.surface.connectivity import lowest_equal_point
from craftmesh.types import GrainTets, Surface


@dataclass(frozen=True)
class Model:
    """All grains' tets on common nodes: the surface's points, then the interior points of each grain."""

    surface: Surface
    grain_tets: Sequence[GrainTets]

    @cached_property
    def points(self) -> np.ndarray:
        """Coordinates (n, 3) of all nodes."""
        return np.concatenate([self.surface.points, *(one.interior for one in self.grain_tets)])

    @cached_property
    def tets(self) -> np.ndarray:
        """Tets (m, 4) of all grains, one grain after another."""
        first, blocks = len(self.surface.points), []
        for one in self.grain_tets:
            ids = np.concatenate([one.nodes, first + np.arange(len(one.interior))])
            blocks.append(ids[one.tets])
            first += len(one.interior)
        return np.concatenate(blocks)

    @cached_property
    def grain(self) -> np.ndarray:
        """Grain id (m,) of each tet."""
        count = [len(one.tets) for one in self.grain_tets]
        return np.repeat([one.grain for one in self.grain_tets], count)

    def moved(self, points: np.ndarray) -> "Model":
        """Return the model with its nodes at `points` (n, 3); coincident surface points stay coincident."""
        old = self.surface.points
        on_surface = points[: len(old)][lowest_equal_point(old)]
        starts = np.cumsum([len(old), *(len(one.interior) for one in self.grain_tets)])
        inner = [points[a : a + len(one.interior)] for a, one in zip(starts, self.grain_tets)]
        grains = [replace(one, interior=interior) for one, interior in zip(self.grain_tets, inner)]
        found = Model(replace(self.surface, points=on_surface), grains)
        found.__dict__["tets"] = self.tets  # the same nodes
        return found


def regrouped(
    model: Model, rows: np.ndarray, points: np.ndarray, tets: np.ndarray, grain: np.ndarray
) -> Model:
    """Return the model with the tets (k, 4) of grains (k,) instead of its tets `rows`.

    points (n, 3): the model's points, then new points. Interior points that no tet uses are removed.
    """
    first, result = len(model.surface.points), list(model.grain_tets)
    stays = np.ones(len(model.tets), bool)
    stays[rows] = False
    changed = set(grain.tolist())
    stop = 0
    for i, one in enumerate(result):
        start, stop = stop, stop + len(one.tets)
        if one.grain in changed:
            kept = model.tets[start:stop][stays[start:stop]]
            corners = np.concatenate([kept, tets[grain == one.grain]])
            inner = np.unique(corners[corners >= first])
            ids = np.concatenate([one.nodes, inner])
            local = np.searchsorted(ids, corners)
            result[i] = GrainTets(one.grain, one.nodes, points[inner], local)
    return Model(model.surface, result)
