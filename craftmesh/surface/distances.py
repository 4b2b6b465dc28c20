"""How far places lie from facets, and on which side of them."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.surface.kernels.distances import ROUNDING, nearest_facets


def distances_and_sides(
    places: np.ndarray, points: np.ndarray, facets: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far places (q, 3) lie from facets (f, 3), at least one, on points (n, 3), and their sides.

    Distances (q,) are to the nearest facet; sides (q,) are 1 ahead of its plane and -1 behind or on it.
    """
    corners = points[facets]
    centres = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1) * (1 + ROUNDING)
    places = np.ascontiguousarray(places)
    some = cKDTree(centres).query(places)[1]
    _, distance2, side = nearest_facets(places, points, facets, some, centres, reach)
    return np.sqrt(distance2), side
