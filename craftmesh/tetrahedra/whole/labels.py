"""Which grain or void a place of the model lies in, by the winding numbers of the surface's labels."""

import numpy as np
from scipy.spatial.transform import Rotation

from craftmesh.surface.kernels.bins import Bins, cells_of, fill_bins, grid_over
from craftmesh.tetrahedra.kernels.label_lookup import winding_labels
from craftmesh.types import Surface

# Looks along no direction in which meshes of voxels have edges or facets.
VIEW = Rotation.from_rotvec([0.3711, 0.6183, 0.2047]).as_matrix()
# Bins along the longer axis at most.
MAX_CELLS = 1000


def labels_at(surface: Surface, places: np.ndarray) -> np.ndarray:
    """Return the labels (q,) int64 at `places` (q, 3): a grain, -k in the void k, 0 outside the material.

    A label's winding number is counted by the facets that lie straight above a place, so facets that
    intersect only leave doubt between them, where the largest number decides.
    """
    points, seen = surface.points @ VIEW.T, places @ VIEW.T
    facets, sides = surface.facets.astype(np.int64), surface.sides.astype(np.int64)
    bins = _bins_from_above(points, facets)
    return winding_labels(seen, bins, points, facets, sides)


def _bins_from_above(points: np.ndarray, facets: np.ndarray) -> Bins:
    """Return bins of the facets over x and y; their grid is one cell high."""
    flat = points * [1.0, 1.0, 0.0]
    low, high = flat.min(axis=0), flat.max(axis=0)
    corners = flat[facets]
    width = max(np.ptp(corners[:, :, :2], axis=1).mean(), (high - low).max() / MAX_CELLS)
    grid = grid_over(low, high, float(width))
    return fill_bins(cells_of(corners.min(axis=1), grid), cells_of(corners.max(axis=1), grid), grid)
