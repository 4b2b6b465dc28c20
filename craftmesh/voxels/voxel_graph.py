"""Connected pieces of a labelled volume and the faces that they share (6-connectivity)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pieces:
    """The pieces of a volume, numbered 0.. in scan order of their first voxels.

    of (nx, ny, nz) int64: piece of each voxel; label (p,) int64; voxels (p,) int64; touches_box (p,) bool.
    """

    of: np.ndarray
    label: np.ndarray
    voxels: np.ndarray
    touches_box: np.ndarray


def find_pieces(labels: np.ndarray) -> Pieces:
    """Return the 6-connected pieces of equal labels in a volume (nx, ny, nz)."""
    from skimage.measure import label

    background = int(labels.min()) - 1  # occurs nowhere, so every label has pieces
    of = label(labels.astype(np.int64), background=background, connectivity=1).astype(np.int64) - 1
    voxels = np.bincount(of.ravel())
    first = np.empty(len(voxels), np.int64)
    first[of.ravel()[::-1]] = np.arange(of.size - 1, -1, -1)  # of repeated indices the last value stays
    order = np.argsort(first)
    rank = np.argsort(order)
    touches = np.zeros(len(first), bool)
    for axis in range(3):
        for end in (0, -1):
            touches[np.take(of, end, axis=axis)] = True
    return Pieces(rank[of], labels.ravel()[first[order]].astype(np.int64), voxels[order], touches[order])


def pieces_per_grain(pieces: Pieces) -> dict[int, int]:
    """Return the number of pieces of each grain that has several, by grain id."""
    grains, count = np.unique(pieces.label[pieces.label > 0], return_counts=True)
    return dict(zip(grains[count > 1].tolist(), count[count > 1].tolist()))


def shared_faces(of: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return sorted pairs (k, 2) of pieces that share faces, lower first, and the numbers of faces (k,)."""
    keys = []
    for axis in range(3):
        low = np.moveaxis(of, axis, 0)[:-1]
        high = np.moveaxis(of, axis, 0)[1:]
        differ = low != high
        a, b = low[differ], high[differ]
        keys.append(np.minimum(a, b) * count + np.maximum(a, b))
    pairs, faces = np.unique(np.concatenate(keys), return_counts=True)
    return np.stack([pairs // count, pairs % count], axis=1), faces


def neighbours(pairs: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return adjacency lists: the neighbours of piece p, ascending, are ids[starts[p] : starts[p + 1]]."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    starts = np.searchsorted(both[:, 0], np.arange(count + 1))
    return starts, both[:, 1]
