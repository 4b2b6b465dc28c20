"""The type `FileVolume` that readers of microstructures return, and their common functions."""

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
_TABLE_LIMIT = 10_000_000  # largest number of rows of a table of orientations, 32 bytes each
_ORIENTATIONS = re.compile(r"euler|bunge|quat|rodrig|orient|rotation|axis_?angle|^phi_?[12]$", re.I)
# Tests of an array's name for its content.
is_eulers, is_quaternions = re.compile(r"euler", re.I).search, re.compile(r"quat", re.I).search
is_phases = re.compile(r"(cell|feature|grain|parent)?_?phases?(_?ids?)?", re.I).fullmatch
is_ids = re.compile(
    r"(cell|feature|grain|parent|region|twin|material)_?ids?|material|labels?", re.I
).fullmatch
_UNITS = {
    DEGREES: re.compile(r"deg(?![a-z])|degree|°", re.I),
    RADIANS: re.compile(r"\brad\b|Rad\b|radian", re.I),
}
# Crystal systems of DREAM.3D's codes 0 to 10 (Laue classes; 999: unknown), from its filter Create Ensemble
# Info.
_DREAM3D = (
    *("hexagonal", "cubic", "hexagonal", "cubic", "triclinic", "monoclinic", "orthorhombic"),
    *("tetragonal", "tetragonal", "trigonal", "trigonal"),
)
# Number of the last space group of each crystal system (International Tables for Crystallography A).
_LAST_GROUP = {2: "triclinic", 15: "monoclinic", 74: "orthorhombic", 142: "tetragonal", 167: "trigonal"}
_LAST_GROUP |= {194: "hexagonal", 230: "cubic"}
# Crystal systems of Laue groups, by which Neper may name a symmetry.
_LAUE = {"-1": "triclinic", "2/m": "monoclinic", "mmm": "orthorhombic"}
_LAUE |= dict.fromkeys(("-3", "-3m"), "trigonal") | dict.fromkeys(("4/m", "4/mmm"), "tetragonal")
_LAUE |= dict.fromkeys(("6/m", "6/mmm"), "hexagonal") | dict.fromkeys(("m-3", "m-3m"), "cubic")


@dataclass(frozen=True)
class Rotations:
    """Orientations as a file contains them: values (g, k), row = id, or (nx, ny, nz, k) of voxels.

    kind: QUATERNIONS (w, x, y, z) of the active rotation from crystal to sample axes; RODRIGUES vectors of
    this rotation, axis * tan(angle / 2); MATRICES of Bunge, from sample to crystal axes, row by row; or the
    angles EULERS (Bunge), KOCKS or ROE. unit: DEGREES or RADIANS, "" if neither the file nor its format
    states it. inverse: whether the values describe the inverse rotations. Unknown values are NaN.
    """

    kind: str
    values: np.ndarray
    unit: str = ""
    inverse: bool = False


@dataclass(frozen=True)
class FileVolume:
    """The arrays of one file, with its ids unchanged.

    labels (nx, ny, nz) of any number type, axes x, y, z; spacing, origin (3,), None if the file has none;
    orientations: Rotations by their name in the file; if they are of voxels, a grain gets their mean;
    phases (g,), row = id in the file, or (nx, ny, nz) of voxels, of which a grain gets the most frequent,
    or None; crystals: phase -> Crystal, phase 0 if there are no phases; zero: meaning of label 0 in this
    format, UNSAID if it differs between files; negative_voids: whether a label -k is the enclosed void k;
    notes: sentences for the report; name: the labels' array in the file, "" in formats with one array.
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
    """Return a volume with its axes in the order x, y, z.

    axes: the file's order, a permutation of "xyz" (not checked). Raises CraftmeshError unless `labels` has
    three axes.
    """
    if labels.ndim != 3:
        raise CraftmeshError(f"{where} has shape {labels.shape}; give an array with three axes")
    return labels.transpose([axes.index(axis) for axis in "xyz"])


def as_numbers(name: str, values: ArrayLike) -> np.ndarray:
    """Return a file's values as float64.

    Raises CraftmeshError, with `name`, for text, complex numbers and objects.
    """
    found = np.asarray(values)
    if found.dtype.kind not in "iufb":
        raise CraftmeshError(f"{name} is of type {found.dtype}; expected real numbers")
    return found.astype(float)


def ids_in_text(path: str | os.PathLike, words: Sequence[bytes]) -> np.ndarray:
    """Return the ids (n,) in a file's words as int64; raises CraftmeshError if one is not an integer."""
    wrong = next((word for word in words if not _ID.fullmatch(word)), None)
    if wrong is not None:
        label = wrong[:30].decode("ascii", "replace")
        raise CraftmeshError(f"{path}: label {label} is not an integer of 64 bits; use integer grain ids")
    return np.array(words, np.int64)


def table_rows(path: str | os.PathLike, labels: np.ndarray) -> int:
    """Return the number of rows of a table with row = label: the largest label plus 1.

    Raises CraftmeshError above 10 million rows.
    """
    rows = max(int(labels.max(initial=0)), 0) + 1
    if rows > _TABLE_LIMIT:
        raise CraftmeshError(
            f"{path}: largest id is {rows - 1}, but with orientations or phases the limit is below "
            f"{_TABLE_LIMIT}; renumber the grains"
        )
    return rows


def pick(path: str | os.PathLike, dataset: str, present: list[str], wanted: tuple[str, ...]) -> str:
    """Return the dataset to read: `dataset` if given, else the first of `wanted`, else the only one.

    present: names in the file. Raises CraftmeshError, with these names, if there is none or no unique one.
    """
    if not present:
        asked = dataset or wanted[0]
        raise CraftmeshError(f"{path}: contains no volume of integers; add a dataset such as {asked}")
    if dataset:
        if dataset in present:
            return dataset
        raise CraftmeshError(f"{path}: no dataset {dataset}; set dataset to one of: {listed(present)}")
    for name in wanted:
        if name in present:
            return name
    if len(present) == 1:
        return present[0]
    raise CraftmeshError(f"{path}: no dataset {wanted[0]}; set dataset to one of: {listed(present)}")


def is_described(name: str) -> bool:
    """Return True if an array's name suggests orientations, phases or grain ids."""
    return bool(_ORIENTATIONS.search(name) or is_phases(name) or is_ids(name))


def unit_said(*texts: str) -> str:
    """Return DEGREES or RADIANS if the texts name exactly one of these units, else ""."""
    named = [unit for unit, pattern in _UNITS.items() if any(pattern.search(text) for text in texts)]
    return named[0] if len(named) == 1 else ""


def belonging(
    path: str | os.PathLike, rows: Mapping[str, int], largest: int, claimed: Collection[int] = ()
) -> str:
    """Return the name of the table, row = id, that belongs to ids up to `largest`; "" if none does.

    rows: number of rows by table name; claimed: numbers of rows that other arrays of ids need. A table with
    exactly largest + 1 rows is preferred. Otherwise a longer table is used, because the volume may be a
    part of a larger one, unless its number of rows is in `claimed`. Raises CraftmeshError if several tables
    fit equally well.
    """
    wanted = largest + 1
    fitting = [name for name, count in rows.items() if count == wanted]
    fitting = fitting or [name for name, count in rows.items() if count > wanted and count not in claimed]
    if len(fitting) > 1:
        raise CraftmeshError(
            f"{path}: several tables fit ids up to {largest}: {listed(fitting)}; "
            "set table to one of them or its group"
        )
    return fitting[0] if fitting else ""


def left_unread(names: Iterable[str]) -> tuple[str, ...]:
    """Return a note, in a tuple, on the arrays `names` that were not read; empty without names."""
    names = list(names)
    return (f"not read: {listed(names)}",) if names else ()


def in_words(value: bytes | str) -> str:
    """Return a text value of an HDF5 file as str."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def of_dream3d(code: int) -> str:
    """Return the crystal system of a DREAM.3D code, "" if it is unknown."""
    return _DREAM3D[code] if 0 <= code < len(_DREAM3D) else ""


def of_space_group(number: int) -> str:
    """Return the crystal system of a space group 1 to 230, "" for other numbers."""
    return next((word for last, word in _LAST_GROUP.items() if 1 <= number <= last), "")


def of_symmetry(word: str) -> str:
    """Return the crystal system of a Laue group such as m-3m, or `word` if it is one; else ""."""
    return word if word in _LAST_GROUP.values() else _LAUE.get(word, "")


def of_grains(crystals: Mapping[int, Crystal], phases: np.ndarray | None) -> dict[int, Crystal]:
    """Return the crystals by phase; without `phases`, a single crystal gets key 0, several are left out."""
    if phases is not None:
        return dict(crystals)
    return dict(zip([0], crystals.values())) if len(crystals) == 1 else {}
