"""Absorption of pieces of few voxels into the neighbour with which they share the most faces."""

import heapq

import numpy as np

from craftmesh.voxels.voxel_graph import Pieces, shared_faces


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
