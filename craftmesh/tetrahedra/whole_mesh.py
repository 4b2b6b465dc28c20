"""The tetrahedra of all grains on common nodes, for changes that affect neighbouring grains."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from craftmesh.mesh.common_nodes import common_points, common_tets, grain_of_tets
from craftmesh.surface.connectivity import lowest_equal_point
from craftmesh.tetrahedra.kernels.tet_quality import COMBINED_QUALITY, all_qualities
from craftmesh.types import GrainTets, Surface


@dataclass(frozen=True)
class Model:
    """All grains' tets on common nodes: the surface's points, then the interior points of each grain."""

    surface: Surface
    grain_tets: Sequence[GrainTets]

    @cached_property
    def points(self) -> np.ndarray:
        """Coordinates (n, 3) of all nodes."""
        return common_points(self.surface, self.grain_tets)

    @cached_property
    def tets(self) -> np.ndarray:
        """Tets (m, 4) of all grains, one grain after another."""
        return common_tets(self.surface, self.grain_tets)

    @cached_property
    def grain(self) -> np.ndarray:
        """Grain id (m,) of each tet."""
        return grain_of_tets(self.grain_tets)

    @cached_property
    def quality(self) -> np.ndarray:
        """Quality (m,) of each tet by the measure COMBINED_QUALITY (`tet_quality`)."""
        quality = np.empty(len(self.tets))
        all_qualities(self.points, self.tets, len(quality), quality, COMBINED_QUALITY)
        return quality

    def moved(self, points: np.ndarray, quality: np.ndarray) -> "Model":
        """Return the model with its nodes at `points` (n, 3).

        Surface points that coincide in this model get the position of the lowest of them. quality (m,): of
        the tets at the new positions (not checked).
        """
        old = self.surface.points
        on_surface = points[: len(old)][lowest_equal_point(old)]
        start, grains = len(old), []
        for one in self.grain_tets:
            interior = points[start : start + len(one.interior)]
            stays = np.array_equal(interior, one.interior)
            grains.append(one if stays else replace(one, interior=interior))
            start += len(interior)
        found = Model(replace(self.surface, points=on_surface), grains)
        found.__dict__.update(tets=self.tets, quality=quality)
        return found


def regrouped(
    model: Model,
    rows: np.ndarray,
    points: np.ndarray,
    tets: np.ndarray,
    grain: np.ndarray,
    quality: np.ndarray,
) -> Model:
    """Return the model with new tets (k, 4) instead of its tets `rows`.

    points (n, 3): the model's points, then new points. grain, quality (k,): of the new tets, quality by
    COMBINED_QUALITY. Interior points that no tet uses are removed.
    """
    stays, used = np.ones(len(model.tets), bool), np.zeros(len(points), bool)
    stays[rows] = False
    used[model.tets[stays]] = used[tets] = True
    order = np.argsort(grain, kind="stable")
    tets, quality, ascending = tets[order], quality[order], grain[order]
    number, result, qualities = np.empty(len(points), np.int64), [], []
    stop, inside = 0, len(model.surface.points)
    for one in model.grain_tets:
        start, stop = stop, stop + len(one.tets)
        own = np.arange(inside, inside + len(one.interior))
        inside += len(own)
        new = slice(*np.searchsorted(ascending, (one.grain, one.grain + 1)))
        kept = stays[start:stop]
        qualities += [model.quality[start:stop][kept], quality[new]]
        if len(tets[new]):
            made = np.unique(tets[new][tets[new] >= len(model.points)])
            inner = np.concatenate([own[used[own]], made])
            number[one.nodes] = np.arange(len(one.nodes))
            number[inner] = len(one.nodes) + np.arange(len(inner))
            corners = np.concatenate([model.tets[start:stop][kept], tets[new]])
            one = GrainTets(one.grain, one.nodes, points[inner], number[corners])
        result.append(one)
    found = Model(model.surface, result)
    found.__dict__["quality"] = np.concatenate(qualities)
    return found
