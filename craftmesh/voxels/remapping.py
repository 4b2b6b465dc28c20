"""Conversion of a file's labels to grains, voids and background, and of its tables by label."""

import os
from dataclasses import dataclass, field

import numpy as np

from craftmesh.errors import CraftmeshError, listed
from craftmesh.io.file_volume import as_numbers, table_rows
from craftmesh.types import GRAIN, UNINDEXED, Voxels

_LARGEST = np.iinfo(np.int32).max


@dataclass(frozen=True)
class RawVolume:
    """A volume as read, before cleaning.

    voxels: labels > 0 grains, -k the declared void k, 0 background. unindexed: mask (nx, ny, nz) of voxels
    of material whose grain is unknown; their label is 0. remap: label in the file -> label in `voxels`, for
    every label that occurs, sorted. notes: sentences for the report. background: meaning of label 0 if it
    was found from the volume, else "".
    """

    voxels: Voxels
    unindexed: np.ndarray
    remap: dict[int, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    background: str = ""

    def __post_init__(self) -> None:
        if self.unindexed.shape != self.voxels.labels.shape or self.unindexed.dtype != bool:
            raise CraftmeshError(
                f"RawVolume.unindexed is an array {self.unindexed.dtype} {self.unindexed.shape}; "
                f"expected bool {self.voxels.labels.shape}"
            )


def as_raw(voxels: Voxels) -> RawVolume:
    """Return voxels, all indexed, as a RawVolume with unchanged labels."""
    labels = np.unique(voxels.labels).tolist()
    return RawVolume(voxels, np.zeros(voxels.labels.shape, bool), dict(zip(labels, labels)))


@dataclass(frozen=True)
class Meaning:
    """The meaning of a file's labels.

    background: UNINDEXED, VOID or GRAIN, the meaning of the label background_value. void_labels: labels v
    that are the void v. negative_voids: whether each label -k is the void k.
    """

    background: str
    background_value: int = 0
    void_labels: tuple[int, ...] = ()
    negative_voids: bool = False


@dataclass(frozen=True)
class Renaming:
    """New labels of a file's labels.

    remap: label in the file -> new label, a grain > 0, a void < 0 or 0; unindexed: the file's labels for
    voxels whose grain is unknown.
    """

    remap: dict[int, int]
    unindexed: tuple[int, ...]
    notes: tuple[str, ...]

    def renamed(self, labels: np.ndarray) -> np.ndarray:
        """Return the new labels (nx, ny, nz) int32 of voxels with the file's `labels` (nx, ny, nz)."""
        old = np.array(sorted(self.remap), np.int64)
        new = np.array([self.remap[label] for label in old.tolist()], np.int32)
        return new[np.searchsorted(old, labels)]


def integer_labels(path: str | os.PathLike, labels: np.ndarray) -> np.ndarray:
    """Return labels (nx, ny, nz) as int64; raises CraftmeshError for flat volumes and invalid ids."""
    shape = " x ".join(map(str, labels.shape))
    if labels.size == 0:
        raise CraftmeshError(
            f"{path}: the volume is empty ({shape} voxels); give at least 2 along each axis"
        )
    if min(labels.shape) < 2:
        raise CraftmeshError(
            f"{path}: the volume has {shape} voxels; give at least 2 along each axis, because "
            "a slice one voxel thick cannot be meshed"
        )
    if labels.dtype.kind == "f":
        wrong = ~(labels == np.round(labels))
        if wrong.any():
            raise CraftmeshError(
                f"{path}: label {labels[wrong][0]} is not an integer grain id; "
                "segment an image of grey values first"
            )
    elif labels.dtype.kind not in "iub":
        raise CraftmeshError(f"{path}: labels have the type {labels.dtype}; save them as integers")
    low, high = labels.min().item(), labels.max().item()
    if high >= _LARGEST or low < -_LARGEST:
        raise CraftmeshError(
            f"{path}: labels range from {low} to {high}, but the limit is {_LARGEST} (int32); "
            "renumber them by numpy.unique with return_inverse"
        )
    if labels.dtype.kind == "f" and max(high, -low) >= (exact := 2 ** (np.finfo(labels.dtype).nmant + 1)):
        raise CraftmeshError(
            f"{path}: labels range from {low:.0f} to {high:.0f} as {labels.dtype}, which rounds ids above "
            f"{exact}, so that grains merge; export them as integers"
        )
    return labels.astype(np.int64)


def refuse_scattered(path: str | os.PathLike, name: str, labels: np.ndarray) -> None:
    """Raise CraftmeshError if most neighbouring voxels differ in their labels (nx, ny, nz).

    Such labels are voxel numbers or grey values, because grains are several voxels wide. Voxels of label 0
    do not count. One or two other labels are accepted as phases. name: the array's, for the error.
    """
    same, neighbours = 0, 0
    for axis in range(3):
        along = np.moveaxis(labels, axis, 0)
        low, high = along[:-1], along[1:]
        is_known = (low != 0) & (high != 0)
        neighbours += int(is_known.sum())
        same += int((is_known & (low == high)).sum())
    ids = len(np.unique(labels[labels != 0])) if 2 * same < neighbours else 0
    if ids <= 2:
        return
    array = f"array {name}" if name else "the volume"
    is_index = 2 * ids > np.count_nonzero(labels)
    what = "voxel numbers" if is_index else "grey values, or grains sampled too coarsely"
    raise CraftmeshError(
        f"{path}: {array} has {ids} labels in {labels.size} voxels, but only {100 * same / neighbours:.2g} "
        f"% of neighbours have the same label: these are {what}; set dataset to the array of grain ids, or "
        "segment the image first"
    )


def rename(path: str | os.PathLike, ids: np.ndarray, meaning: Meaning) -> Renaming:
    """Return the new labels of a file's sorted ids (k,): grains keep their ids, or get + 1 if 0 is a grain.

    Raises CraftmeshError for a void label that does not occur, and for negative ids that are not declared.
    """
    present = ids.tolist()
    absent = [v for v in meaning.void_labels if v not in present]
    if absent:
        raise CraftmeshError(f"{path}: void label {absent[0]} does not occur; use one of {listed(present)}")
    value = meaning.background_value
    empty = set(meaning.void_labels) | ({value} if meaning.background != GRAIN else set())
    voids = set(meaning.void_labels) - {0, value}
    if meaning.negative_voids:
        voids |= {v for v in present if v < 0}
    grains = [v for v in present if v not in empty | voids]
    if negative := [v for v in grains if v < 0]:
        are = f"label {negative[0]} is" if len(negative) == 1 else f"labels {listed(negative)} are"
        way = "unique with return_inverse" if {-v for v in negative} & {*grains} else "abs"
        raise CraftmeshError(
            f"{path}: {are} negative; renumber grains (such as ExaCA's nucleated ones) by numpy.{way}, "
            "declare voids by void_labels, or a background by background_value"
        )
    shift = 1 if 0 in grains else 0
    named = {v: v + shift for v in grains} | {v: -abs(v) - shift for v in voids}
    is_unindexed = meaning.background == UNINDEXED and value not in meaning.void_labels
    notes = ("label 0 is a grain, so every id is the file's id + 1",) if shift else ()
    return Renaming({v: named.get(v, 0) for v in present}, (value,) if is_unindexed else (), notes)


def phases_by_voxels(
    path: str | os.PathLike, phases: np.ndarray, labels: np.ndarray, is_grain: np.ndarray
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the most frequent phase (g,) of each label's voxels, of equals the lowest, and notes.

    phases, labels, is_grain (nx, ny, nz); labels that are not grains get 0. A note lists grains of several
    phases with the percentage of voxels in other phases. Raises CraftmeshError for different shapes.
    """
    if phases.shape != labels.shape:
        raise CraftmeshError(
            f"{path}: phases has shape {phases.shape}; expected one number per voxel, {labels.shape}"
        )
    ids, grain = np.unique(labels[is_grain], return_inverse=True)
    numbers, phase = np.unique(as_numbers(f"{path}: phases", phases)[is_grain], return_inverse=True)
    votes = np.bincount(grain * len(numbers) + phase, minlength=len(ids) * len(numbers))
    votes = votes.reshape(len(ids), len(numbers))
    table = np.zeros(table_rows(path, ids))
    table[ids] = numbers[votes.argmax(axis=1)] if len(ids) else 0
    other = 1 - votes.max(axis=1, initial=0) / np.maximum(votes.sum(axis=1), 1)
    mixed = sorted(np.flatnonzero(other > 0), key=lambda k: -other[k])
    if not mixed:
        return table, ()
    worst = listed(f"{ids[k]} ({100 * other[k]:.2g}%)" for k in mixed)
    return table, (f"grains of several phases get the most frequent one; percentage of others: {worst}",)


def phase_table(
    path: str | os.PathLike, phases: np.ndarray | None, remap: dict[int, int]
) -> np.ndarray | None:
    """Return a file's phases (g,), row = id in the file, as int64; None if it has none.

    Raises CraftmeshError for phases that are not integers >= 0, and for grains without a phase.
    """
    if phases is None:
        return None
    numbers = as_numbers(f"{path}: phases", phases)
    if numbers.ndim != 1:
        raise CraftmeshError(f"{path}: phases has shape {numbers.shape}; expected one number per grain id")
    grains = np.array([old for old, new in remap.items() if new > 0], np.int64)
    lacking = grains[grains >= len(numbers)]
    if len(lacking):
        raise CraftmeshError(
            f"{path}: no phase for grains {listed(lacking)}, the table has {len(numbers)} rows; write one "
            "row per grain id, row 0 for id 0"
        )
    is_phase = (numbers >= 0) & (numbers == np.round(numbers)) & (numbers < _LARGEST)
    wrong = grains[~is_phase[grains]]
    if len(wrong):
        raise CraftmeshError(
            f"{path}: phase of grain {wrong[0]} is {numbers[wrong[0]]:g}; expected an integer >= 0"
        )
    return np.where(is_phase, numbers, 0).astype(np.int64)


def by_grain(path: str | os.PathLike, table: np.ndarray | None, remap: dict[int, int]) -> np.ndarray | None:
    """Return a table with one row per id in the file as a table with row = grain; None if there is none.

    Rows without an entry are NaN, or 0 in integer tables. remap: label in the file -> label. Raises
    CraftmeshError if the ids of the grains are too large for a table.
    """
    if table is None:
        return None
    pairs = np.array([pair for pair in remap.items() if pair[1] > 0], np.int64).reshape(-1, 2)
    old, new = pairs.T
    size = table_rows(path, new)
    made = np.full((size, *table.shape[1:]), np.nan if table.dtype.kind == "f" else 0, table.dtype)
    has_row = old < len(table)
    made[new[has_row]] = table[old[has_row]]
    return made
