"""Edge lengths of a surface, carried into what it bounds: used where no sizing function is given."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import mean_edges


class LocalSizing:
    """Target edge lengths that follow those of the facets (m, 3) on points (n, 3)."""

    def __init__(self, points: np.ndarray, facets: np.ndarray):
        edges, _, _ = unique_edges(facets)
        self.length = mean_edges(points, edges)
        self.tree = cKDTree(points)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the mean length (n,) of the edges at the surface's node nearest to each point (n, 3)."""
        return self.length[self.tree.query(points)[1]]
