"""Which grain or void a place of the model lies in, by the winding numbers of the surface's labels."""

import numpy as np
from scipy.spatial.transform import Rotation

from craftmesh.tetrahedra.kernels.label_lookup import bin_facets, winding_labels
from craftmesh.types import Surface

# Looks along no direction in which meshes of voxels have edges or facets.
VIEW = Rotation.from_rotvec([0.3711, 0.6183, 0.2047]).as_matrix()
MAX_CELLS = 1000


def labels_at(surface: Surface, places: np.ndarray) -> np.ndarray:
    """Return the labels (q,) int64 at `places` (q, 3): a grain, -k in the void k, 0 outside the material.

    A label's winding number is counted by the facets that lie straight above a place, so facets that
    intersect only leave doubt between them, where the largest number decides.
    """
    points, seen = surface.points @ VIEW.T, places @ VIEW.T
    facets, sides = surface.facets.astype(np.int64), surface.sides.astype(np.int64)
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    corners = points[facets][:, :, :2]
    width = max(np.ptp(corners, axis=1).mean(), (high - low).max() / MAX_CELLS)
    shape = ((high - low) / width).astype(np.int64) + 1
    start, items = bin_facets(points, facets, low, width, shape)
    return winding_labels(seen, start, items, low, width, shape, points, facets, sides)
