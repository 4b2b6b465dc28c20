"""What every reader of a microstructure format returns, and the checks that they share."""

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from craftmesh.errors import CraftmeshError, listed
from craftmesh.types import Crystal

UNSAID = ""
QUATERNIONS, RODRIGUES, MATRICES = "quaternions", "rodrigues", "matrices"
EULERS, KOCKS, ROE = "eulers", "kocks", "roe"
DEGREES, RADIANS = "degrees", "radians"
_ID = re.compile(rb"-?[0-9]{1,18}")
_TABLE_LIMIT = 10_000_000  # rows of orientations, 32 bytes each


@dataclass(frozen=True)
class Rotations:
    """Orientations as a file holds them: values (g, k), row = id, or (nx, ny, nz, k) of voxels.

    kind: QUATERNIONS (w, x, y, z) of the active rotation from crystal to sample axes, RODRIGUES vectors of
    it, axis * tan(angle / 2), MATRICES of Bunge, from sample to crystal axes, row by row, or angles after
    EULERS (Bunge), KOCKS or ROE; unit: DEGREES or RADIANS as the file or its format says, "" where neither
    does; inverse: whether the values are those of the inverse rotations; NaN is unknown.
    """

    kind: str
    values: np.ndarray
    unit: str = ""
    inverse: bool = False


@dataclass(frozen=True)
class FileVolume:
    """The arrays of one file, ids untouched.

    labels (nx, ny, nz) of any number type, axes x, y, z; spacing, origin (3,) or None where the file has
    none; orientations: Rotations by their name in the file, of which a grain takes the mean where they are
    of voxels; phases (g,), row = id in the file, or (nx, ny, nz) of voxels, of which a grain takes the most
    frequent, or None; crystals: phase -> Crystal, phase 0 where there are no phases; zero: what label 0
    means in this format, UNSAID where each file has its own way; negative_voids: whether a label -k is the
    enclosed void k; notes for the report.
    """

    labels: np.ndarray
    spacing: np.ndarray | None = None
    origin: np.ndarray | None = None
    orientations: Mapping[str, Rotations] = field(default_factory=dict)
    phases: np.ndarray | None = None
    crystals: Mapping[int, Crystal] = field(default_factory=dict)
    zero: str = UNSAID
    negative_voids: bool = False
    notes: tuple[str, ...] = ()


def to_xyz(labels: np.ndarray, axes: str, where: str) -> np.ndarray:
    """Return a volume with its axes in the order x, y, z; `axes` names the file's order, as "zyx"."""
    if labels.ndim != 3:
        raise CraftmeshError(f"{where} has shape {labels.shape}; expected a volume of three axes")
    return labels.transpose([axes.index(axis) for axis in "xyz"])


def as_numbers(name: str, values: ArrayLike) -> np.ndarray:
    """Return values of a file as float64; raises CraftmeshError, with their name, for text and objects."""
    found = np.asarray(values)
    if found.dtype.kind not in "iufb":
        raise CraftmeshError(f"{name} is of type {found.dtype}; expected real numbers")
    return found.astype(float)


def ids_in_text(path: str | os.PathLike, words: Sequence[bytes]) -> np.ndarray:
    """Return the ids (n,) in the words of a file as int64; CraftmeshError for what is no whole number."""
    wrong = next((word for word in words if not _ID.fullmatch(word)), None)
    if wrong is not None:
        label = wrong[:30].decode("ascii", "replace")
        raise CraftmeshError(f"{path}: label {label} is not a whole number of int64; expected grain ids")
    return np.array(words, np.int64)


def table_rows(path: str | os.PathLike, labels: np.ndarray) -> int:
    """Return the rows of a table by label, its largest + 1; CraftmeshError where too many."""
    rows = max(int(labels.max(initial=0)), 0) + 1
    if rows > _TABLE_LIMIT:
        raise CraftmeshError(
            f"{path}: ids reach {rows - 1}; expected below {_TABLE_LIMIT} beside orientations or phases, "
            "renumber the grains"
        )
    return rows


def pick(path: str | os.PathLike, dataset: str, present: list[str], wanted: tuple[str, ...]) -> str:
    """Return the dataset to read: the one asked for, else the first of `wanted`, else the only one.

    Raises CraftmeshError that lists those present.
    """
    if not present:
        asked = dataset or wanted[0]
        raise CraftmeshError(
            f"{path}: holds no volume of whole numbers; expected a dataset such as {asked}"
        )
    if dataset:
        if dataset in present:
            return dataset
        raise CraftmeshError(f"{path}: no dataset {dataset}; give dataset as one of: {listed(present)}")
    for name in wanted:
        if name in present:
            return name
    if len(present) == 1:
        return present[0]
    raise CraftmeshError(f"{path}: no dataset {wanted[0]}; give dataset as one of: {listed(present)}")
