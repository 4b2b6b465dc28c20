"""What readers of microstructures return, and what they share: arrays by their names, crystals."""

import os
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
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
_ORIENTATIONS = re.compile(r"euler|bunge|quat|rodrig|orient|rotation|axis_?angle|^phi_?[12]$", re.I)
# What an array's name says that it holds.
is_eulers, is_quaternions = re.compile(r"euler", re.I).search, re.compile(r"quat", re.I).search
is_phases = re.compile(r"(cell|feature|grain|parent)?_?phases?(_?ids?)?", re.I).fullmatch
is_ids = re.compile(
    r"(cell|feature|grain|parent|region|twin|material)_?ids?|material|labels?", re.I
).fullmatch
_UNITS = {
    DEGREES: re.compile(r"deg(?![a-z])|degree|°", re.I),
    RADIANS: re.compile(r"\brad\b|Rad\b|radian", re.I),
}
# DREAM.3D's codes 0 to 10 (Laue classes; 999 is unknown), as its filter Create Ensemble Info lists them.
_DREAM3D = (
    *("hexagonal", "cubic", "hexagonal", "cubic", "triclinic", "monoclinic", "orthorhombic"),
    *("tetragonal", "tetragonal", "trigonal", "trigonal"),
)
# The last space group of each structure (International Tables for Crystallography A).
_LAST_GROUP = {2: "triclinic", 15: "monoclinic", 74: "orthorhombic", 142: "tetragonal", 167: "trigonal"}
_LAST_GROUP |= {194: "hexagonal", 230: "cubic"}
# Laue groups, as Neper names symmetries beside the words themselves.
_LAUE = {"-1": "triclinic", "2/m": "monoclinic", "mmm": "orthorhombic"}
_LAUE |= dict.fromkeys(("-3", "-3m"), "trigonal") | dict.fromkeys(("4/m", "4/mmm"), "tetragonal")
_LAUE |= dict.fromkeys(("6/m", "6/mmm"), "hexagonal") | dict.fromkeys(("m-3", "m-3m"), "cubic")


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
    enclosed void k; notes for the report; name of the labels' array, "" in formats of one array.
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
    name: str = ""


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


def is_described(name: str) -> bool:
    """Return whether an array's name says that it holds orientations, phases or ids of grains."""
    return bool(_ORIENTATIONS.search(name) or is_phases(name) or is_ids(name))


def unit_said(*texts: str) -> str:
    """Return DEGREES or RADIANS where a file's words name one of them, else ""."""
    named = [unit for unit, pattern in _UNITS.items() if any(pattern.search(text) for text in texts)]
    return named[0] if len(named) == 1 else ""


def belonging(
    path: str | os.PathLike, rows: Mapping[str, int], largest: int, claimed: Collection[int] = ()
) -> str:
    """Return the table that belongs to ids up to `largest`, row = id, or "" where none does.

    rows: table -> how many it has. It is the one with a row for each id and none over; else one with more
    rows, as of a part cut out of a volume, but not one that fits other ids: claimed, their counts of rows.
    Raises CraftmeshError where several fit alike.
    """
    wanted = largest + 1
    fitting = [name for name, count in rows.items() if count == wanted]
    fitting = fitting or [name for name, count in rows.items() if count > wanted and count not in claimed]
    if len(fitting) > 1:
        raise CraftmeshError(
            f"{path}: ids reach {largest}, and several tables fit them: {listed(fitting)}; "
            "give table as one of them or its group"
        )
    return fitting[0] if fitting else ""


def left_unread(names: Iterable[str]) -> tuple[str, ...]:
    """Return the note on arrays of a file that were not read; none without names."""
    names = list(names)
    return (f"left unread: {listed(names)}",) if names else ()


def in_words(value: bytes | str) -> str:
    """Return a text of an HDF5 file."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def of_dream3d(code: int) -> str:
    """Return the structure of a code of DREAM.3D, "" where it is unknown."""
    return _DREAM3D[code] if 0 <= code < len(_DREAM3D) else ""


def of_space_group(number: int) -> str:
    """Return the structure of a space group 1 to 230, "" for other numbers."""
    return next((word for last, word in _LAST_GROUP.items() if 1 <= number <= last), "")


def of_symmetry(word: str) -> str:
    """Return the structure of a Laue group such as m-3m, or of its own word; "" where it is neither."""
    return word if word in _LAST_GROUP.values() else _LAUE.get(word, "")


def of_grains(crystals: Mapping[int, Crystal], phases: np.ndarray | None) -> dict[int, Crystal]:
    """Return the crystals by phase; where grains have none, the only crystal as that of phase 0."""
    if phases is not None:
        return dict(crystals)
    return dict(zip([0], crystals.values())) if len(crystals) == 1 else {}
