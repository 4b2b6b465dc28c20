"""Orientations of grains from a file's quaternions, Rodrigues vectors, matrices or Euler angles."""

import os
from collections.abc import Callable, Mapping

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import (
    DEGREES,
    EULERS,
    KOCKS,
    MATRICES,
    QUATERNIONS,
    RADIANS,
    RODRIGUES,
    ROE,
    Rotations,
    as_numbers,
    table_rows,
)
from craftmesh.mechanics.orientation import (
    angle_between,
    bunge_to_quaternion,
    matrix_to_quaternion,
    mean_by_grain,
    normalized,
    rodrigues_to_quaternion,
)

# Numbers per row and conversion to quaternions. Kocks' and Roe's angles become Bunge's by R. Quey, orilib,
# and U. F. Kocks et al., Texture and Anisotropy (1998), chapter 2.
_TO_QUATERNIONS: dict[str, tuple[int, Callable[[np.ndarray], np.ndarray]]] = {
    QUATERNIONS: (4, normalized),
    RODRIGUES: (3, rodrigues_to_quaternion),
    MATRICES: (9, lambda rows: matrix_to_quaternion(rows.reshape(-1, 3, 3).transpose(0, 2, 1))),
    EULERS: (3, bunge_to_quaternion),
    KOCKS: (3, lambda rows: bunge_to_quaternion(rows * [1, 1, -1] + [np.pi / 2, 0, np.pi / 2])),
    ROE: (3, lambda rows: bunge_to_quaternion(rows + [np.pi / 2, 0, -np.pi / 2])),
}
_MIXED_UP = 1.0  # degrees, largest difference between two tables of a file; float32 angles agree within 0.1
_MIXED_ANGLES = 15.0  # degrees, spread within a grain above which its mean is questionable

_TURN = 2 * np.pi * (1 + 1e-4)  # 2 pi with a margin, as float32 and files of four decimals round it up
# Largest fraction of rows in degrees with all three angles under 2 pi. Among random rotations it is one in
# a million; sharp textures have few such rows.
_SMALL_SHARE = 0.01
_UNINDEXED = 4 * np.pi  # value of all three angles of a point that OIM did not index


def orientation_table(
    path: str | os.PathLike,
    given: Mapping[str, Rotations],
    labels: np.ndarray,
    is_grain: np.ndarray,
    unit: str = "",
) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """Return quaternions (g, 4), row = label, NaN if unknown, and notes; None if the file has none.

    given: FileVolume.orientations; arrays of voxels are averaged over each of the file's labels (nx, ny,
    nz) in the mask `is_grain`; unit: the user's unit of Euler angles, "" to use the file's. Raises
    CraftmeshError for arrays of another shape, and for several that contradict each other.
    """
    tables: dict[str, np.ndarray] = {}
    notes: tuple[str, ...] = ()
    for name, rotations in given.items():
        quaternions, told = _quaternions(path, name, rotations, unit, labels.shape)
        notes += told
        if rotations.values.ndim == 4:
            table_rows(path, labels)
            quaternions, spread = mean_by_grain(labels[is_grain], quaternions[is_grain.ravel()])
            notes += ("orientations are means over each grain's voxels",)
            if spread > _MIXED_ANGLES:
                notes += (
                    f"orientations differ by up to {spread:.0f} degrees within a grain: check the means",
                )
        else:
            notes += _fit(path, name, len(quaternions), np.unique(labels[is_grain]))
        tables[name] = quaternions
    if not tables:
        return None, notes
    _refuse_disagreement(path, tables)
    return next(iter(tables.values())), notes


def quaternions_of_voxels(
    path: str | os.PathLike, given: Mapping[str, Rotations], unit: str = ""
) -> np.ndarray:
    """Return the quaternions (nx, ny, nz, 4) of voxels.

    given: the file's orientations by name; unit: the user's unit of Euler angles, "" to use the file's.
    Raises CraftmeshError if the file has no orientations of voxels.
    """
    for name, rotations in given.items():
        if rotations.values.ndim == 4:
            shape = rotations.values.shape[:3]
            return _quaternions(path, name, rotations, unit, shape)[0].reshape(*shape, 4)
    raise CraftmeshError(
        f"{path}: has no orientations of voxels (found: {', '.join(given) or 'none'}); leave out "
        "voxel_orientations, or give another file"
    )


def _fit(path: str | os.PathLike, name: str, rows: int, ids: np.ndarray) -> tuple[str, ...]:
    """Return a note if a table with row = id has more rows than its ids (k,) need.

    Raises CraftmeshError if the table seems to have one row for each id that occurs, instead of row = id.
    """
    largest = int(ids.max(initial=0))
    if rows == len(ids) <= largest:
        raise CraftmeshError(
            f"{path}: {name} has {rows} rows for {rows} ids up to {largest}; write row = id from 0 on, "
            "with NaN in rows of ids that do not occur"
        )
    if rows <= largest + 1:
        return ()
    return (f"{name} has {rows} rows, but ids reach {largest}: rows beyond are not used",)


def _quaternions(
    path: str | os.PathLike, name: str, rotations: Rotations, unit: str, shape: tuple
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return quaternions (n, 4) of one array, by id or by voxel, and notes on its unit.

    name: the array's name in the file; unit: DEGREES, RADIANS or "" to use the file's; shape: numbers of
    voxels along x, y, z.
    """
    width, convert = _TO_QUATERNIONS[rotations.kind]
    values = as_numbers(f"{path}: {name}", rotations.values)
    if values.shape[-1:] != (width,) or not (values.ndim == 2 or values.shape[:-1] == shape):
        raise CraftmeshError(
            f"{path}: {name} has shape {values.shape}; expected {width} numbers per grain id or voxel"
        )
    rows = np.where(np.isfinite(values), values, np.nan).reshape(-1, width)
    notes: tuple[str, ...] = ()
    if rotations.kind in (EULERS, KOCKS, ROE):
        rows, notes = _in_radians(path, name, rows, unit or rotations.unit)
    return convert(rows) * ([1, -1, -1, -1] if rotations.inverse else 1), notes


def _in_radians(
    path: str | os.PathLike, name: str, angles: np.ndarray, unit: str
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return Euler angles (n, 3) in radians, NaN if not indexed, and notes on their unit.

    unit: DEGREES or RADIANS as the user, file or format states; "": found from the range of the angles.
    Raises CraftmeshError if the range does not show the unit, or exceeds two turns in the stated unit.
    """
    angles = np.where((np.abs(angles - _UNINDEXED) < 1e-3).all(axis=1, keepdims=True), np.nan, angles)
    size = np.abs(angles[np.isfinite(angles).all(axis=1)])
    size = size[size.any(axis=1)]
    largest = size.max(initial=0.0)
    by_range = _unit_by_range(size)
    if unit and largest > 2 * (_TURN if unit == RADIANS else np.degrees(_TURN)):
        raise CraftmeshError(
            f"{path}: {name} reach {largest:.4g}, too much for {unit}; set angles to their true unit"
        )
    if not (unit or by_range):
        small, tops = (size <= _TURN).all(axis=1).sum(), [f"{top:.4g}" for top in size.max(axis=0)]
        raise CraftmeshError(
            f"{path}: {name} reach {', '.join(tops)}, but {small} of {len(size)} rows are below 2 pi, so "
            "their unit is unclear; convert all to one unit, or set angles to radians or degrees"
        )
    notes: tuple[str, ...] = ()
    if not unit and by_range == DEGREES:
        notes = (f"{name} reach {largest:.4g}, so they are read as degrees; if not, set angles: radians",)
    if unit == DEGREES and by_range == RADIANS and len(size):
        notes = (f"{name} are read as degrees, but none exceeds 2 pi; if wrong, set angles: radians",)
    return (np.radians(angles) if (unit or by_range) == DEGREES else angles), notes


def _unit_by_range(size: np.ndarray) -> str:
    """Return the unit of absolute angles (n, 3), rows not all 0, from their range; "" if it is unclear."""
    is_small = (size <= _TURN).all(axis=1)
    if is_small.all():
        return RADIANS
    columns = size.max(axis=0)
    one_unit = ((columns > _TURN) | (columns == 0)).all() and is_small.mean() <= _SMALL_SHARE
    return DEGREES if one_unit and 2 * _TURN < size.max() <= np.degrees(_TURN) else ""


def _refuse_disagreement(path: str | os.PathLike, tables: Mapping[str, np.ndarray]) -> None:
    """Raise CraftmeshError if a table (g, 4) differs from the first by over _MIXED_UP degrees in a row."""
    (first, table), *others = tables.items()
    for name, other in others:
        rows = min(len(table), len(other))
        both = np.isfinite(table[:rows]).all(axis=1) & np.isfinite(other[:rows]).all(axis=1)
        known = np.flatnonzero(both)
        angles = angle_between(table[known], other[known])
        if angles.max(initial=0.0) > _MIXED_UP:
            worst = int(angles.argmax())
            raise CraftmeshError(
                f"{path}: {first} and {name} differ by {angles[worst]:.1f} degrees for grain "
                f"{known[worst]}; both should be the rotation from crystal to sample axes: remove one"
            )
