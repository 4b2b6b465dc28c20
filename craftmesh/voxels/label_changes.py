"""What cleaning does to the labels, in sentences: how many voxels of which share, and the option for it."""

from collections.abc import Mapping

import numpy as np

from craftmesh.errors import counted, listed
from craftmesh.voxels.voxel_graph import Pieces


def filling(counts: Mapping[str, int], total: int) -> list[str]:
    """Return what became of unindexed voxels: how many were filled, how many no grain reaches."""
    notes, filled, left = [], counts["filled_voxels"], counts["unindexed_voxels_left_empty"]
    if filled:
        notes = [
            f"{counted(filled, total)} without a grain went to the grains around them (fill_unindexed); "
            "background void keeps them empty"
        ]
    if left:
        notes.append(f"{counted(left, total)} without a grain are left empty: no grain reaches them")
    return notes


def voids(before: np.ndarray, after: np.ndarray) -> list[str]:
    """Return what labels (nx, ny, nz) <= 0 have become: enclosed voids, or the outside."""
    ids, voxels = np.unique(after[after <= 0], return_counts=True)
    if not len(ids):
        return []
    outside, enclosed = int(voxels[ids == 0].sum()), ids[ids < 0]
    note = f"{counted(int(voxels.sum()), after.size)} are empty: {len(enclosed)} enclosed voids"
    note += f", and {counted(outside, after.size)} open to the box's faces, outside" if outside else ""
    gone = np.setdiff1d(before[before < 0], enclosed)
    if len(gone):
        note += f"; voids {listed((-gone[::-1]).tolist())} touch another or the outside and are part of it"
    return [f"{note} (background, void_labels)"]


def absorption(pieces: Pieces, new_label: np.ndarray, minimum: int) -> list[str]:
    """Return what pieces under `minimum` voxels have joined; new_label (p,): each piece's label then."""
    changed = new_label != pieces.label
    if not changed.any():
        return []
    voxels = counted(int(pieces.voxels[changed].sum()), int(pieces.voxels.sum()))
    note = (
        f"min_island_voxels {minimum} gave {int(changed.sum())} pieces, {voxels}, to what they touch most"
    )
    gone = np.setdiff1d(pieces.label, new_label)
    return [note + (f"; nothing is left of {emptied(pieces, new_label)}" if len(gone) else "")]


def emptied(pieces: Pieces, new_label: np.ndarray) -> str:
    """Return which labels absorption has emptied, the largest first, and which absorbed them."""
    gone = np.setdiff1d(pieces.label, new_label)
    of = {int(label): np.flatnonzero(pieces.label == label) for label in gone}
    order = sorted(of, key=lambda label: (-int(pieces.voxels[of[label]].sum()), label))
    return listed(_one_emptied(label, pieces.voxels[of[label]], new_label[of[label]]) for label in order)


def _one_emptied(label: int, voxels: np.ndarray, became: np.ndarray) -> str:
    pieces = f"{len(voxels)} pieces, " if len(voxels) > 1 else ""
    to = listed(map(_named, np.unique(became).tolist()))
    return f"{_named(label)} ({pieces}{int(voxels.sum())} voxels, to {to})"


def _named(label: int) -> str:
    return f"grain {label}" if label > 0 else f"void {-label}" if label else "the outside"


def smoothing(voxels: int, total: int) -> list[str]:
    """Return how many voxels smoothing has given to another grain."""
    if not voxels:
        return []
    return [f"smoothing_rounds gave {counted(voxels, total)} to another grain; 0 rounds change none"]


def splitting(parents: dict[int, int], labels: np.ndarray) -> list[str]:
    """Return which grains of labels (nx, ny, nz) were split; parents: new id -> the grain it came from."""
    if not parents:
        return []
    voxels = counted(int((labels >= min(parents)).sum()), labels.size)
    return [
        f"split_pieces made {len(parents)} pieces of {len(set(parents.values()))} grains, {voxels}, "
        f"grains of their own: {min(parents)} to {max(parents)}"
    ]
