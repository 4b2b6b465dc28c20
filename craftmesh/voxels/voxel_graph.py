"""Connected components (pieces) of a volume by voxel faces, their common faces, and their absorption."""

import heapq
from dataclasses import dataclass

import numpy as np

from craftmesh.voxels.kernels.pieces import number_pieces

# Voxels, size below which a piece of a grain is a speck: 3 x 3 x 3. To keep small grains, it is at most
# SPECK_SHARE of the median grain, which has 2,000 voxels in AL1050 and 90 in the copper.
SPECK, SPECK_SHARE = 27, 0.1


@dataclass(frozen=True)
class Pieces:
    """The pieces of a volume, numbered from 0 in scan order of their first voxels.

    of (nx, ny, nz) int64: piece of each voxel; label (p,) int64: label of each piece; voxels (p,) int64:
    number of voxels in each piece; touches_box (p,): mask of pieces at the box's faces.
    """

    of: np.ndarray
    label: np.ndarray
    voxels: np.ndarray
    touches_box: np.ndarray


def find_pieces(labels: np.ndarray) -> Pieces:
    """Return the 6-connected pieces of equal labels in a volume (nx, ny, nz)."""
    of = number_pieces(np.ascontiguousarray(labels, np.int64))
    voxels = np.bincount(of.ravel())
    label = np.empty(len(voxels), np.int64)
    label[of] = labels
    touches = np.zeros(len(voxels), bool)
    for axis in range(3):
        for end in (0, -1):
            touches[np.take(of, end, axis=axis)] = True
    return Pieces(of, label, voxels, touches)


def pieces_per_grain(pieces: Pieces) -> dict[int, int]:
    """Return the number of pieces of each grain that has several, by grain id."""
    grains, count = np.unique(pieces.label[pieces.label > 0], return_counts=True)
    return dict(zip(grains[count > 1].tolist(), count[count > 1].tolist()))


def shared_faces(of: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return sorted pairs (k, 2) of pieces that share voxel faces, lower first, and their face counts (k,).

    of (nx, ny, nz): piece of each voxel; count: at least the number of pieces.
    """
    keys = []
    for axis in range(3):
        low = np.moveaxis(of, axis, 0)[:-1]
        high = np.moveaxis(of, axis, 0)[1:]
        differ = low != high
        a, b = low[differ], high[differ]
        keys.append(np.minimum(a, b) * count + np.maximum(a, b))
    pairs, faces = np.unique(np.concatenate(keys), return_counts=True)
    return np.stack([pairs // count, pairs % count], axis=1), faces


def median_grain(labels: np.ndarray) -> float:
    """Return the median number of voxels of the grains (labels > 0); 0 without grains."""
    counts = np.unique(labels[labels > 0], return_counts=True)[1]
    return float(np.median(counts)) if len(counts) else 0.0


def speck_size(labels: np.ndarray) -> int:
    """Return the size in voxels below which a piece of labels (nx, ny, nz) is a speck, at most SPECK."""
    return int(min(SPECK, SPECK_SHARE * median_grain(labels)))


def dispersed(pieces: Pieces, minimum: int) -> np.ndarray:
    """Return labels (k,) that have at least `minimum` voxels, but most of them in pieces of fewer."""
    labels, of = np.unique(pieces.label, return_inverse=True)
    voxels = np.bincount(of, pieces.voxels)
    in_specks = np.bincount(of, np.where(pieces.voxels < minimum, pieces.voxels, 0))
    return labels[(voxels >= minimum) & (2 * in_specks > voxels)]


def absorb_small_pieces(pieces: Pieces, minimum: int) -> np.ndarray:
    """Return the label (p,) of each piece after every piece under `minimum` voxels has joined a neighbour.

    The smallest piece is first. A piece joins the grain with which it shares the most faces (of equals the
    lowest id), or a void or the outside only if it touches no grain. It then connects all pieces of that
    label that it touches. A piece without neighbours stays.
    """
    if minimum <= 1 or not (pieces.voxels < minimum).any():
        return pieces.label
    merging = _Merging(pieces)
    waiting = [(int(n), p) for p, n in enumerate(pieces.voxels.tolist()) if n < minimum]
    heapq.heapify(waiting)
    while waiting:
        voxels, piece = heapq.heappop(waiting)
        if merging.root[piece] != piece or merging.voxels[piece] != voxels:
            continue
        joined = merging.absorb(piece)
        if joined is not None and merging.voxels[joined] < minimum:
            heapq.heappush(waiting, (merging.voxels[joined], joined))
    return np.array([merging.label[merging.find(p)] for p in range(len(pieces.label))], np.int64)


class _Merging:
    """Union-find of pieces that are merged, with the face counts between the roots."""

    def __init__(self, pieces: Pieces):
        self.root = list(range(len(pieces.label)))
        self.label = pieces.label.tolist()
        self.voxels = pieces.voxels.tolist()
        self.faces: list[dict[int, int]] = [{} for _ in self.root]
        pairs, faces = shared_faces(pieces.of, len(self.root))
        for (a, b), shared in zip(pairs.tolist(), faces.tolist()):
            self.faces[a][b] = self.faces[b][a] = shared

    def find(self, piece: int) -> int:
        while self.root[piece] != piece:
            self.root[piece] = self.root[self.root[piece]]
            piece = self.root[piece]
        return piece

    def absorb(self, piece: int) -> int | None:
        """Merge a root piece into the neighbour label with most faces; return the merged root.

        Grains come before voids and the outside. None without neighbours.
        """
        shared: dict[int, int] = {}
        for other, faces in self.faces[piece].items():
            shared[self.label[other]] = shared.get(self.label[other], 0) + faces
        if not shared:
            return None
        label = max(shared, key=lambda k: (k > 0, shared[k], -abs(k)))
        parts = [p for p in self.faces[piece] if self.label[p] == label]
        largest = max(parts, key=lambda p: (self.voxels[p], -p))
        for part in (piece, *parts):
            if part != largest:
                self._join(part, largest)
        return largest

    def _join(self, piece: int, target: int) -> None:
        self.root[piece] = target
        self.voxels[target] += self.voxels[piece]
        for other, faces in self.faces[piece].items():
            del self.faces[other][piece]
            if other != target:
                self.faces[target][other] = self.faces[target].get(other, 0) + faces
                self.faces[other][target] = self.faces[target][other]
        self.faces[piece] = {}
