"""Crack fronts as csv text with a header that names x, y, z."""

import csv
import os
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError

_CRAFTMESHER_XYZ = slice(7, 10)


def write_front(path: str | os.PathLike, columns: Mapping[str, np.ndarray]) -> None:
    """Write one row per front node, in order; a column (k, 3) becomes `name_x`, `name_y`, `name_z`.

    The column `points` (k, 3) is written as x, y, z. Floats keep every bit; integers stay integers.
    """
    flat: dict[str, np.ndarray] = {}
    for name, values in columns.items():
        values = np.asarray(values)
        if values.ndim == 2:
            names = list("xyz") if name == "points" else [f"{name}_{axis}" for axis in "xyz"]
            flat |= dict(zip(names, values.T))
        else:
            flat[name] = values
    with atomic_path(path) as temporary, open(temporary, "w", newline="", encoding="ascii") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(flat)
        writer.writerows(zip(*(values.tolist() for values in flat.values())))


def read_path(path: str | os.PathLike) -> np.ndarray:
    """Return the points (k, 2) of a path in a plane: the columns x and y; errors as `read_front`."""
    columns = read_front(path, "xy")
    return np.stack([columns["x"], columns["y"]], axis=1)


def read_front(path: str | os.PathLike, axes: str = "xyz") -> dict[str, np.ndarray]:
    """Read a front: its columns (k,) by their names in the header, at least x, y and z, or those of `axes`.

    A file without a header is taken as craftmesher's, with x, y, z in columns 7, 8, 9 counted from 0,
    or as bare x,y,z when it has three columns. Columns with text are left out. Raises CraftmeshError
    for a missing file, missing columns or coordinates that are not finite numbers.
    """
    rows = _rows(path)
    if _is_number(rows[0][0]):
        names = _headerless_names(path, len(rows[0]))
    else:
        names, rows = [name.strip() for name in rows[0]], rows[1:]
    for number, row in enumerate(rows, 1):
        if len(row) != len(names):
            raise CraftmeshError(
                f"{path}: row {number} has {len(row)} columns; expected {len(names)} as in the first"
            )
    columns = {name: _numbers([row[i] for row in rows]) for i, name in enumerate(names) if name}
    for axis in axes:
        if axis not in columns:
            raise CraftmeshError(
                f"{path}: no column {axis!r} (found: {', '.join(names)}); the header must name "
                f"{', '.join(axes)}"
            )
        values = columns[axis]
        if values is None or not len(values) or not np.isfinite(values).all():
            raise _not_numbers(path, axis, [row[names.index(axis)] for row in rows])
    return {name: values for name, values in columns.items() if values is not None}


def read_front_points(path: str | os.PathLike) -> np.ndarray:
    """Return the points (k, 3) of a front file, in its order; errors as `read_front`."""
    columns = read_front(path)
    return np.stack([columns[axis] for axis in "xyz"], axis=1)


def read_fronts(path: str | os.PathLike) -> list[np.ndarray]:
    """Return the fronts (k, 3) of a file, as polylines in its order; errors as `read_front`.

    A column `front` tells them apart, as in front.csv; where a column `closed` is 1 the first point comes
    again at the end.
    """
    columns = read_front(path)
    points = np.stack([columns[axis] for axis in "xyz"], axis=1)
    number, closed = (columns.get(name, np.zeros(len(points))) for name in ("front", "closed"))
    fronts = []
    for own in (number == k for k in np.unique(number)):
        ring = closed[own].any() and (points[own][0] != points[own][-1]).any()
        fronts.append(np.concatenate([points[own], points[own][:1]]) if ring else points[own])
    return fronts


def read_words(path: str | os.PathLike, name: str) -> list[str] | None:
    """Return a column of text of a file with a header, row by row; None where it has no such column."""
    names, *rows = _rows(path)
    names = [own.strip() for own in names]
    return [row[names.index(name)] for row in rows] if name in names else None


def has_word(cells: Iterable[str], words: Collection[str]) -> np.ndarray:
    """Return which cells (k,), words joined by + as in the column `flags`, hold one of `words`."""
    return np.array([not set(words).isdisjoint(str(cell).split("+")) for cell in cells], bool)


def _rows(path: str | os.PathLike) -> list[list[str]]:
    if not Path(path).is_file():
        raise CraftmeshError(f"{path}: no such file; give a csv with columns x, y, z")
    with open(path, newline="", encoding="utf-8-sig", errors="replace") as stream:
        rows = [row for row in csv.reader(stream) if any(field.strip() for field in row)]
    if not rows:
        raise CraftmeshError(f"{path}: empty; expected a csv with columns x, y, z")
    return rows


def _headerless_names(path: str | os.PathLike, width: int) -> list[str]:
    if width == 3:
        return list("xyz")
    if width < _CRAFTMESHER_XYZ.stop:
        raise CraftmeshError(f"{path}: {width} columns and no header; add a header that names x, y, z")
    names = [""] * width
    names[_CRAFTMESHER_XYZ] = "xyz"
    return names


def _not_numbers(path: str | os.PathLike, name: str, cells: list[str]) -> CraftmeshError:
    """Return what is said of a column whose cells are not all finite numbers, or that has none."""
    for number, cell in enumerate(cells, 1):
        if not (_is_number(cell) and np.isfinite(float(cell))):
            return CraftmeshError(f"{path}: row {number}: {name} is {cell!r}; expected a finite number")
    return CraftmeshError(f"{path}: no row under the header; expected at least one point")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _numbers(texts: list[str]) -> np.ndarray | None:
    try:
        return np.array([float(text) for text in texts])
    except ValueError:
        return None
