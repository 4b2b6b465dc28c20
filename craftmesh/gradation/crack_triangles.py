"""The triangles that the crack's vertices are put on, in bins: the given crack's, else the input's own.

The input's crack facets are chords of the given crack. Vertices put on them, and facets measured against
them, would add what the gradation leaves to what the insertion left.
"""

import numpy as np

from craftmesh.surface.kernels.bins import cells_of, fill_bins, grid_over
from craftmesh.surface.measure import area_vectors, meets_box
from craftmesh.types import CRACK, Crack, Surface

# Part of the box within which the crack counts as flat.
FLAT = 1e-9
# Bins are as wide as the mean triangle is long, and no more than so many.
MOST_BINS = 2_000_000


def crack_triangles(surface: Surface, given: Crack | None) -> dict[str, np.ndarray]:
    """Return the arrays `crack_*` of Guards: the triangles near the crack of `surface`, and their bins.

    There are none where the crack of `surface` lies in one plane: vertices then stay on it by themselves.
    """
    inserted = surface.facets[surface.kind == CRACK].astype(np.int64)
    if not len(inserted) or _is_flat(surface.points, inserted):
        return _binned(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
    if given is None:
        return _binned(surface.points, inserted)
    return _binned(given.points, _near(given, surface.points[inserted]))


def _near(given: Crack, inserted: np.ndarray) -> np.ndarray:
    """Return the given triangles (t, 3) that are no farther from all the inserted ones than one is long."""
    longest = np.ptp(inserted, axis=1).max()
    reach = np.stack([inserted.min(axis=(0, 1)) - longest, inserted.max(axis=(0, 1)) + longest])
    triangles = given.triangles.astype(np.int64)
    return triangles[meets_box(given.points[triangles], reach)]


def _is_flat(points: np.ndarray, facets: np.ndarray) -> bool:
    normal = area_vectors(points, facets)
    total = normal.sum(0)
    if not np.linalg.norm(total) > 0:
        return False
    total /= np.linalg.norm(total)
    height = points[np.unique(facets)] @ total
    return bool(np.ptp(height) <= FLAT * max(1.0, np.ptp(points, axis=0).max()))


def _binned(points: np.ndarray, triangles: np.ndarray) -> dict[str, np.ndarray]:
    """Return the arrays of triangles (t, 3) and of the bins that their bounds meet."""
    corners = points[triangles].reshape(-1, 3, 3)
    lower, upper = corners.min(axis=1), corners.max(axis=1)
    low, high = (lower.min(axis=0), upper.max(axis=0)) if len(triangles) else np.zeros((2, 3))
    width = max((upper - lower).max(axis=1).mean(), 1e-300) if len(triangles) else 1.0
    while np.prod((high - low) / width + 1) > MOST_BINS:
        width *= 1.25
    grid = grid_over(low, high, width)
    bins = fill_bins(cells_of(lower, grid), cells_of(upper, grid), grid)
    return {
        # a type's points are read-only, which would compile all kernels once more for them
        "crack_points": np.array(points, float, order="C"),
        "crack_triangles": triangles,
        "crack_bin_start": bins.start,
        "crack_bin_items": bins.items,
        "crack_bin_low": bins.grid.low,
        "crack_bin_width": np.array([bins.grid.width]),
        "crack_bin_shape": bins.grid.shape,
    }
