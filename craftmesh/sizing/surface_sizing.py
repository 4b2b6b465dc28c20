"""Edge lengths of a surface, carried into what it bounds: used where no sizing function is given."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.surface.connectivity import unique_edges


class LocalSizing:
    """Target edge lengths that follow those of the facets (m, 3) on points (n, 3)."""

    def __init__(self, points: np.ndarray, facets: np.ndarray):
        edges, _, _ = unique_edges(facets)
        length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
        count = np.bincount(edges.ravel(), minlength=len(points))
        total = np.bincount(edges.ravel(), np.repeat(length, 2), len(points))
        self.length = total / np.maximum(count, 1)
        self.tree = cKDTree(points)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the mean length (n,) of the edges at the surface's node nearest to each point (n, 3)."""
        return self.length[self.tree.query(points)[1]]
