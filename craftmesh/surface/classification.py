"""Classification of a surface's vertices: which patches, lines, box planes and crack limit their motion."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.ranks import AT_JUNCTION, line_ranks
from craftmesh.surface.kernels.tied import tied_vertices
from craftmesh.surface.patches import FeatureEdges, Patches, feature_edges, patches
from craftmesh.types import BORDER, CRACK, Surface


@dataclass(frozen=True)
class Classification:
    """The freedom of motion of the n vertices of a surface; each property is computed at its first use.

    given_patches: patches to use instead of `patches(surface)`, for example patches that end along folds.
    """

    surface: Surface
    given_patches: Patches | None = None

    @cached_property
    def features(self) -> FeatureEdges:
        """The edges of the surface, and which of them are feature edges."""
        return feature_edges(self.surface, self.patch)

    @cached_property
    def degree(self) -> np.ndarray:
        """(n,) int64: number of feature edges at each vertex."""
        return np.bincount(self.features.lines.ravel(), minlength=len(self.surface.points))

    @cached_property
    def rank(self) -> np.ndarray:
        """(n,) int64: IN_PATCH (0), ON_LINE (1) or AT_JUNCTION (2).

        A vertex on a line has two feature edges, with the same patches at both. A vertex where parts of the
        surface meet without a common edge is a junction.
        """
        facets, count = self.surface.facets.astype(np.int64), len(self.surface.points)
        rank = line_ranks(facets, self.patch, count)
        rank[tied_vertices(facets, count)] = AT_JUNCTION
        return rank

    @cached_property
    def planes(self) -> np.ndarray:
        """(n,) int64: bit mask of the box planes in which each vertex lies, bit 1 << (k - 1) for kind k."""
        planes = np.zeros(len(self.surface.points), np.int64)
        for k in range(1, CRACK):
            planes[self.surface.facets[self.surface.kind == k]] |= 1 << (k - 1)
        return planes

    @cached_property
    def held(self) -> np.ndarray:
        """(n, 3) bool: coordinates fixed by box planes; all three at a corner of the box and on borders.

        A border facet is where a part was cut out of a mesh.
        """
        by_planes = (self.planes[:, None] >> np.array([0, 2, 4])) & 3 != 0
        return by_planes | self.on_border[:, None]

    @cached_property
    def on_border(self) -> np.ndarray:
        """(n,) bool: vertices of border facets."""
        return self._among(self.surface.facets[self.surface.kind == BORDER])

    @cached_property
    def on_crack(self) -> np.ndarray:
        """(n,) bool: vertices of crack facets."""
        return self._among(self.surface.facets[self.surface.kind == CRACK])

    @cached_property
    def on_front(self) -> np.ndarray:
        """(n,) bool: vertices of the crack's front."""
        return self._among(front_edges(self.surface))

    @property
    def free(self) -> np.ndarray:
        """(n, 3) bool: coordinates fixed neither by box planes nor by the crack."""
        return ~(self.held | self.on_crack[:, None])

    @cached_property
    def patch(self) -> np.ndarray:
        """(m,) int64: the patch of each facet."""
        return (self.given_patches or patches(self.surface)).of_facet

    def _among(self, corners: np.ndarray) -> np.ndarray:
        among = np.zeros(len(self.surface.points), bool)
        among[corners] = True
        return among
