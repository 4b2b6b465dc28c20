"""Noise of measured volumes: ragged grain boundaries, and voxels shuffled across them."""

import numpy as np
from scipy import ndimage

RAGGED_LENGTH = 1.5  # voxels along which boundaries stray alike: steps, not a gentle bend


def stray_offsets(
    shape: tuple[int, int, int], spacing: np.ndarray, amount: float, rng: np.random.Generator
) -> np.ndarray:
    """Return offsets (nx, ny, nz, 3) of the places where cells are asked for, in model units.

    Their root mean square is `amount` voxels along each axis; they are alike over about 1.5 voxels.
    """
    offsets = np.empty((*shape, 3))
    for axis in range(3):
        field = ndimage.gaussian_filter(rng.standard_normal(shape), RAGGED_LENGTH, mode="wrap")
        offsets[..., axis] = field * (amount * spacing[axis] / np.sqrt(np.mean(field**2)))
    return offsets


def shuffle_boundaries(labels: np.ndarray, share: float, rounds: int, rng: np.random.Generator) -> None:
    """Give boundary voxels of `labels` (nx, ny, nz) the grain of a face neighbour, in place.

    In each round, every grain voxel looks at one of its six neighbours, chosen at random, and takes its
    grain with probability `share`. Voids and the outside stay and spread nowhere.
    """
    for _ in range(rounds):
        padded = np.pad(labels, 1)
        ways = rng.integers(0, 6, labels.shape)
        chance = rng.random(labels.shape) < share
        taken = labels.copy()
        for way in range(6):
            shifted = np.roll(padded, 1 if way % 2 else -1, axis=way // 2)[1:-1, 1:-1, 1:-1]
            chosen = chance & (ways == way) & (labels > 0) & (shifted > 0)
            taken[chosen] = shifted[chosen]
        labels[...] = taken
