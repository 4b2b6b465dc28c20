"""The label of the grain or void at a position, from the facets around it."""

from functools import cache

import numpy as np
import scipy

from craftmesh.surface.kernels.bins import cells_of, fill_bins, grid_over
from craftmesh.surface.kernels.label_lookup import winding_labels

# Rotation vector of the direction in which facets above a place are searched. Meshes of voxels have no
# edges or facets along it, so no search hits one edge-on.
VIEW = (0.3711, 0.6183, 0.2047)
# Most cells of the search grid along its longer axis.
MAX_CELLS = 1000


def labels_at(places: np.ndarray, points: np.ndarray, facets: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Return labels (q,) int64 at `places` (q, 3): a grain, -k in void k, 0 outside the material.

    points (n, 3), facets (m, 3), sides (m, 2) as in Surface. A label's winding number, how often its
    boundary encloses the place, is summed over the facets straight above a place, and the largest number
    decides. Intersecting facets therefore only affect places between them.
    """
    view = _view()
    points, facets = points @ view.T, facets.astype(np.int64)
    flat = points * [1.0, 1.0, 0.0]
    low, high = flat.min(axis=0), flat.max(axis=0)
    corners = flat[facets]
    width = max(np.ptp(corners[:, :, :2], axis=1).mean(), (high - low).max() / MAX_CELLS)
    grid = grid_over(low, high, float(width))
    bins = fill_bins(cells_of(corners.min(axis=1), grid), cells_of(corners.max(axis=1), grid), grid)
    labels: np.ndarray = winding_labels(places @ view.T, bins, points, facets, sides.astype(np.int64))
    return labels


@cache
def _view() -> np.ndarray:
    """Return the rotation matrix (3, 3) of VIEW."""
    return scipy.spatial.transform.Rotation.from_rotvec(VIEW).as_matrix()
