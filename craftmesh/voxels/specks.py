"""Which pieces are specks, and which labels lie in them."""

import numpy as np

from craftmesh.voxels.voxel_graph import Pieces

# A piece of a grain under so many voxels, three across, is a speck to a mesh; but grains stay: at most
# SPECK_SHARE of the median grain. The median grain of AL1050 has 2,000 voxels, that of the copper 90.
SPECK, SPECK_SHARE = 27, 0.1


def median_grain(labels: np.ndarray) -> float:
    """Return the median count of voxels of the grains, labels > 0; 0 without a grain."""
    counts = np.unique(labels[labels > 0], return_counts=True)[1]
    return float(np.median(counts)) if len(counts) else 0.0


def speck_size(labels: np.ndarray) -> int:
    """Return the size in voxels under which pieces of the grains in `labels` (nx, ny, nz) are specks."""
    return int(min(SPECK, SPECK_SHARE * median_grain(labels)))


def dispersed(pieces: Pieces, minimum: int) -> np.ndarray:
    """Return the labels (k,) of at least `minimum` voxels, most of which are in pieces of fewer."""
    labels, of = np.unique(pieces.label, return_inverse=True)
    voxels = np.bincount(of, pieces.voxels)
    in_specks = np.bincount(of, np.where(pieces.voxels < minimum, pieces.voxels, 0))
    return labels[(voxels >= minimum) & (2 * in_specks > voxels)]
