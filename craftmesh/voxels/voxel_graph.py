"""Connected pieces of a volume and the faces that they share (6-connectivity); small ones absorbed."""

import heapq
from dataclasses import dataclass

import numpy as np

from craftmesh.voxels.kernels.pieces import number_pieces

# A piece of a grain under so many voxels, three across, is a speck to a mesh; but grains stay: at most
# SPECK_SHARE of the median grain. The median grain of AL1050 has 2,000 voxels, that of the copper 90.
SPECK, SPECK_SHARE = 27, 0.1


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


def absorb_small_pieces(pieces: Pieces, minimum: int) -> np.ndarray:
    """Return the label (p,) of each piece after every piece under `minimum` voxels joined a neighbour.

    Smallest first. A piece joins the grain that shares the most faces with it (ties: the lowest id), a void
    or the outside only where it touches no grain; it may thereby join several pieces of that grain to one.
    A piece without neighbours stays.
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
    """Pieces that grow together: union-find with the faces shared between the roots."""

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
        """Give a piece to its best neighbour; return the joined piece, None where it has no neighbour."""
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
