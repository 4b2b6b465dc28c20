"""The tetrahedra of all grains on common nodes, for changes that neighbours have to see alike."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from craftmesh.sizing.length_field import LocalSizing
from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.connectivity import lowest_equal_point, touching
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.types import GrainTets, Surface


@dataclass(frozen=True)
class Model:
    """All grains' tets on common nodes: the surface's points, then the interior points of each grain."""

    surface: Surface
    grain_tets: Sequence[GrainTets]

    @property
    def points(self) -> np.ndarray:
        """(n, 3) all nodes."""
        return np.concatenate([self.surface.points, *(one.interior for one in self.grain_tets)])

    @property
    def tets(self) -> np.ndarray:
        """(m, 4) the tets of all grains, one grain after another."""
        first, blocks = len(self.surface.points), []
        for one in self.grain_tets:
            ids = np.concatenate([one.nodes, first + np.arange(len(one.interior))])
            blocks.append(ids[one.tets])
            first += len(one.interior)
        return np.concatenate(blocks)

    @property
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


def nodes_near(tets: np.ndarray, bad: np.ndarray) -> np.ndarray:
    """Return (n,) bool: the nodes of bad tets, by rows or (m,) bool, and of those at these nodes."""
    near = np.zeros(int(tets.max()) + 1, bool)
    near[tets[bad]] = True
    near[tets[touching(tets, near)]] = True
    return near


# What is done to the tets of a grain: of points (n, 3), tets (m, 4), how many points lie on the surface,
# crack facets inside (c, 3) and target lengths it makes points and tets; those on the surface, the first
# ones, stay.
Change = Callable[[np.ndarray, np.ndarray, int, np.ndarray, Lengths], tuple[np.ndarray, np.ndarray]]


def changed_inside(model: Model, grains: np.ndarray, change: Change) -> Model:
    """Return the model with the tets of `grains` changed; their target lengths are the surface's own."""
    result = list(model.grain_tets)
    surfaces = {one.grain: one for one in grain_surfaces(model.surface, grains)}
    for i, one in enumerate(model.grain_tets):
        if one.grain not in surfaces:
            continue
        surface = surfaces[one.grain]
        points = np.concatenate([model.surface.points[one.nodes], one.interior])
        internal = np.searchsorted(one.nodes, surface.nodes[surface.facets[surface.internal]])
        sizing = LocalSizing(surface.points, surface.facets)
        points, tets = change(points, one.tets, len(one.nodes), internal, sizing)
        result[i] = GrainTets(one.grain, one.nodes, points[len(one.nodes) :], tets)
    return Model(model.surface, result)
