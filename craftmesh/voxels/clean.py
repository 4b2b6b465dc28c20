"""Cleaning of a labelled volume: afterwards each voxel belongs to a grain, an enclosed void or the outside.

The steps: fill unindexed voxels, number empty ones as voids, absorb islands of few voxels, smooth grain
boundaries, split grains in several pieces.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError, counted, listed
from craftmesh.progress import silent
from craftmesh.types import Voxels
from craftmesh.voxels.options import CleanOptions
from craftmesh.voxels.remapping import RawVolume, as_raw
from craftmesh.voxels.smoothing import smooth_boundaries
from craftmesh.voxels.voxel_graph import (
    SPECK,
    Pieces,
    absorb_small_pieces,
    dispersed,
    find_pieces,
    pieces_per_grain,
)

_SMALLEST_LISTED = 10
# Roughness above which the report recommends smoothing. Measured: generated grains 0.01, on voxels of
# 1 x 1 x 2 to 2 x 1 x 5 at most 0.04, laths of four voxels 0.05; one voxel in ten shuffled 0.06, two 0.10;
# measured aluminium (LabDCT) 0.10, steel 0.02.
ROUGH = 0.06


def clean(
    volume: RawVolume | Voxels,
    options: CleanOptions = CleanOptions(),  # noqa: B008
    progress: Callable[[float, str], None] = silent,
) -> tuple[Voxels, dict]:
    """Return the cleaned voxels, none of them unindexed, and a report: counts, and each change in words.

    Grain ids stay; pieces that are split off get new ids and their grain's orientation. Raises
    CraftmeshError if there are unindexed voxels but fill_unindexed is not set, if no grain is left, and if
    only one is left but allow_single_grain is not set.
    """
    raw = volume if isinstance(volume, RawVolume) else as_raw(volume)
    total = raw.voxels.labels.size
    progress(0.0, "fill unindexed voxels")
    labels, report, changes = _filled(raw, options)
    changes += _voids(raw.voxels.labels, labels)
    progress(0.4, "absorb islands")
    pieces = find_pieces(labels)
    new_label = absorb_small_pieces(pieces, options.min_island_voxels)
    report["grains_in_pieces_before"] = len(pieces_per_grain(pieces))
    absorbed, told = _absorption(pieces, new_label, options)
    report, changes = report | absorbed, changes + told
    if report["absorbed_pieces"]:
        labels = number_voids(new_label[pieces.of])
        pieces = find_pieces(labels)
    progress(0.6, "smooth grain boundaries")
    labels, smoothing = smooth_boundaries(labels, raw.voxels.spacing, options.smoothing_rounds)
    report |= smoothing
    if smoothed := report["smoothed_voxels"]:
        changes.append(
            f"smoothing_rounds moved {counted(smoothed, total)} to another grain; 0 rounds move none"
        )
        pieces = find_pieces(labels)
    progress(0.8, "pieces of grains")
    report["grains_in_pieces"] = {str(k): n for k, n in pieces_per_grain(pieces).items()}
    parents: dict[int, int] = {}
    if options.split_pieces:
        labels, parents = split_pieces(pieces, int(raw.voxels.labels.max()))
    _check_grains(labels, options)
    if parents:
        voxels = counted(int((labels >= min(parents)).sum()), total)
        changes.append(
            f"split_pieces made {len(parents)} pieces of {len(set(parents.values()))} grains, {voxels}, "
            f"new grains: {min(parents)} to {max(parents)}"
        )
    notes = [*raw.notes, *_rough(report["roughness"], pieces, options)]
    report |= _census(labels, raw, parents) | {"changes": changes, "notes": notes}
    return _with_labels(raw.voxels, labels, parents), report


def _rough(roughness: float, pieces: Pieces, options: CleanOptions) -> list[str]:
    """Return a list with the advice to smooth, if boundaries are rough, or [].

    It is [] also if smoothing is on, or if a grain consists mostly of specks, pieces under SPECK voxels.
    roughness: fraction of the boundaries' area that smoothing removes.
    """
    if roughness <= ROUGH or options.smoothing_rounds or (dispersed(pieces, SPECK) > 0).any():
        return []
    return [
        f"grain boundaries are rough: steps and specks are {100 * roughness:.0f}% of their area, expected "
        f"at most {100 * ROUGH:.0f}%; smoothing_rounds 2 removes them and keeps the grains' volumes"
    ]


def _filled(raw: RawVolume, options: CleanOptions) -> tuple[np.ndarray, dict, list[str]]:
    """Return labels with unindexed voxels filled and voids numbered, counts for the report, and sentences.

    The sentences tell what was filled and what stays empty. Raises CraftmeshError if there are unindexed
    voxels but options.fill_unindexed is not set.
    """
    unindexed = int(raw.unindexed.sum())
    if unindexed and not options.fill_unindexed:
        raise CraftmeshError(
            f"{counted(unindexed, raw.unindexed.size)} have no grain; set fill_unindexed to give them to "
            "the grains around them, or background to void if they are empty, to grain if they are a grain"
        )
    labels, filled = fill_unindexed(raw.voxels.labels, raw.unindexed)
    changes, left = [], unindexed - filled
    if filled:
        changes = [
            f"{counted(filled, labels.size)} without a grain were given to the grains around them "
            "(fill_unindexed); background void keeps them empty"
        ]
    if left:
        changes.append(
            f"{counted(left, labels.size)} without a grain stay empty: no grain is connected to them"
        )
    return number_voids(labels), {"filled_voxels": filled, "unindexed_voxels_left_empty": left}, changes


def _voids(before: np.ndarray, after: np.ndarray) -> list[str]:
    """Return a list of one sentence on the voids and the outside in labels `after`; [] if there are none.

    before: the labels before `number_voids`, with the declared voids.
    """
    ids, voxels = np.unique(after[after <= 0], return_counts=True)
    if not len(ids):
        return []
    outside, enclosed = int(voxels[ids == 0].sum()), ids[ids < 0]
    note = f"{counted(int(voxels.sum()), after.size)} are empty: {len(enclosed)} enclosed voids"
    note += f", and {counted(outside, after.size)} outside, connected to the box's faces" if outside else ""
    gone = np.setdiff1d(before[before < 0], enclosed)
    if len(gone):
        note += f"; voids {listed((-gone[::-1]).tolist())} touch another void or the outside and join it"
    return [f"{note} (background, void_labels)"]


def fill_unindexed(labels: np.ndarray, unindexed: np.ndarray) -> tuple[np.ndarray, int]:
    """Return labels with unindexed voxels given to the grains around them, and the number of voxels given.

    unindexed: mask (nx, ny, nz). Layer by layer, each voxel gets the most frequent grain of its six
    neighbours, of equals the lowest id. Voxels that no grain reaches stay 0.
    """
    padded = np.pad(np.where(unindexed, 0, labels), 1)
    strides = np.array(padded.strides) // padded.itemsize
    steps = np.concatenate([strides, -strides])
    flat = padded.ravel()
    open_voxels = np.flatnonzero(np.pad(unindexed, 1))
    total = len(open_voxels)
    while len(open_voxels):
        around = np.sort(np.maximum(flat[open_voxels[:, None] + steps], 0), axis=1)
        votes = ((around[:, :, None] == around[:, None, :]).sum(axis=2)) * (around > 0)
        winner = around[np.arange(len(around)), votes.argmax(axis=1)]
        reached = votes.any(axis=1)
        if not reached.any():
            break
        flat[open_voxels[reached]] = winner[reached]
        open_voxels = open_voxels[~reached]
    return padded[1:-1, 1:-1, 1:-1].copy(), total - len(open_voxels)


def number_voids(labels: np.ndarray) -> np.ndarray:
    """Return labels in which empty voxels (<= 0) connected to the box's faces are 0, and others voids < 0.

    An enclosed connected piece gets the label -k of the declared void k that has most of its voxels, else
    the next free number in scan order. Several pieces of one declared void all keep its label.
    """
    empty, count = scipy.ndimage.label(labels <= 0)
    ids = np.zeros(count + 1, np.int64)
    taken = set(np.unique(labels[labels < 0]).tolist())
    rim = [np.take(empty, end, axis=axis).ravel() for axis in range(3) for end in (0, -1)]
    outside = set(np.unique(np.concatenate(rim)).tolist())
    free = -1
    for piece, window in enumerate(scipy.ndimage.find_objects(empty), start=1):
        if piece in outside:
            continue
        inside = labels[window][empty[window] == piece]
        declared, votes = np.unique(-inside[inside < 0], return_counts=True)
        if len(declared):
            ids[piece] = -declared[votes.argmax()]
            continue
        while free in taken:
            free -= 1
        ids[piece] = free
        taken.add(free)
    return np.where(empty > 0, ids[empty], labels).astype(np.int32)


def split_pieces(pieces: Pieces, largest_id: int) -> tuple[np.ndarray, dict[int, int]]:
    """Return labels in which every piece of a grain is a grain, and a map new id -> id of its old grain.

    The largest piece keeps the id; the others are numbered after `largest_id`, by grain, the larger first.
    """
    label = pieces.label.copy()
    parents: dict[int, int] = {}
    order = np.lexsort((np.arange(len(label)), -pieces.voxels, label))
    for before, piece in zip(order[:-1].tolist(), order[1:].tolist()):
        if pieces.label[piece] > 0 and pieces.label[before] == pieces.label[piece]:
            new_id = largest_id + len(parents) + 1
            parents[new_id] = int(pieces.label[piece])
            label[piece] = new_id
    if parents and max(parents) >= np.iinfo(np.int32).max:
        raise CraftmeshError(f"split pieces reach id {max(parents)}, beyond int32; renumber the grains")
    return label[pieces.of].astype(np.int32), parents


def _absorption(pieces: Pieces, new_label: np.ndarray, options: CleanOptions) -> tuple[dict, list[str]]:
    """Return counts of absorbed pieces for the report, and a sentence on them in a list.

    new_label (p,): label of each piece after absorption. Raises CraftmeshError if only one label is left,
    unless allow_single_grain is set.
    """
    changed, gone = new_label != pieces.label, np.setdiff1d(pieces.label, new_label)
    counts = {
        "absorbed_pieces": int(changed.sum()),
        "absorbed_voxels": int(pieces.voxels[changed].sum()),
        "absorbed_grains": gone[gone > 0].tolist(),
        "absorbed_voids": (-gone[gone < 0][::-1]).tolist(),
    }
    if not changed.any():
        return counts, []
    if len(set(new_label.tolist())) == 1 and not options.allow_single_grain:
        raise CraftmeshError(
            f"min_island_voxels {options.min_island_voxels} leaves only grain {new_label[0]} and absorbs "
            f"{_emptied(pieces, new_label)}; lower it, or set allow_single_grain"
        )
    voxels = counted(counts["absorbed_voxels"], int(pieces.voxels.sum()))
    told = (
        f"min_island_voxels {options.min_island_voxels} gave {counts['absorbed_pieces']} pieces, {voxels}, "
        "to the neighbours that they touch most"
    )
    return counts, [told + (f"; completely absorbed: {_emptied(pieces, new_label)}" if len(gone) else "")]


def _emptied(pieces: Pieces, new_label: np.ndarray) -> str:
    """Return in words which labels are completely absorbed, the largest first, and by which labels.

    new_label (p,): label of each piece after absorption.
    """
    gone = np.setdiff1d(pieces.label, new_label)
    of = {int(label): np.flatnonzero(pieces.label == label) for label in gone}
    order = sorted(of, key=lambda label: (-int(pieces.voxels[of[label]].sum()), label))
    return listed(_one_emptied(label, pieces.voxels[of[label]], new_label[of[label]]) for label in order)


def _one_emptied(label: int, voxels: np.ndarray, became: np.ndarray) -> str:
    """Return in words what became of a label's pieces: their `voxels` (p,) and new labels `became` (p,)."""
    pieces = f"{len(voxels)} pieces, " if len(voxels) > 1 else ""
    to = listed(map(_named, np.unique(became).tolist()))
    return f"{_named(label)} ({pieces}{int(voxels.sum())} voxels, to {to})"


def _named(label: int) -> str:
    return f"grain {label}" if label > 0 else f"void {-label}" if label else "the outside"


def _check_grains(labels: np.ndarray, options: CleanOptions) -> None:
    """Raise CraftmeshError if no grain is left, or only one unless options.allow_single_grain."""
    low, high = int(labels.min()), int(labels.max())
    if high <= 0:
        raise CraftmeshError("the volume has no grain; check dataset, background and void_labels")
    if low == high and not options.allow_single_grain:
        raise CraftmeshError(
            f"the whole volume is grain {high}, so there is no grain boundary; "
            "check dataset, or set allow_single_grain"
        )


def _with_labels(voxels: Voxels, labels: np.ndarray, parents: dict[int, int]) -> Voxels:
    """Return voxels with new labels; an id in `parents` gets the orientation and phase of its parent."""
    tables = []
    for table, unknown in ((voxels.orientations, np.nan), (voxels.phases, 0)):
        if table is not None:
            size = max(len(table), int(labels.max()) + 1)
            known = table
            table = np.full((size, *known.shape[1:]), unknown, known.dtype)
            table[: len(known)] = known
            for new_id, parent in parents.items():
                table[new_id] = table[parent]
        tables.append(table)
    orientations, phases = tables
    return replace(voxels, labels=labels, orientations=orientations, phases=phases)


def _census(labels: np.ndarray, raw: RawVolume, parents: dict[int, int]) -> dict:
    """Return the report's counts of the cleaned labels, and `remap`.

    remap: id in the file, a string -> list of the labels that it became, empty if it was absorbed. Ids that
    became 0 (outside) are left out.
    """
    ids, count = np.unique(labels, return_counts=True)
    voxels = dict(zip(ids.tolist(), count.tolist()))
    grains = sorted((n, k) for k, n in voxels.items() if k > 0)
    pieces: dict[int, list[int]] = {}
    for new_id, parent in parents.items():
        pieces.setdefault(parent, []).append(new_id)
    became = {
        str(old): [k for k in (new, *pieces.get(new, [])) if k in voxels]
        for old, new in raw.remap.items()
        if new != 0
    }
    return {
        "grains": len(grains),
        "voids": {str(-k): n for k, n in sorted(voxels.items(), reverse=True) if k < 0},
        "outside_voxels": voxels.get(0, 0),
        "split_grains": {str(new_id): parent for new_id, parent in parents.items()},
        "smallest_grains": [[k, n] for n, k in grains[:_SMALLEST_LISTED]],
        "remap": became,
    }
