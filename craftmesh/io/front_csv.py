"""Crack fronts as text with a header that names x, y, z."""

import csv
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.io.text_table import Table, read_table

_CRAFTMESHER_XYZ = 7  # the first of the columns x, y, z
# A column of names: a front's rows come once for each, and those of the first count.
LOAD_CASE = "load_case"
_KNOWN = {"x", "y", "z", "front", "closed"}


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


def rows_by_load(columns: Mapping[str, Mapping[str, np.ndarray]]) -> Mapping[str, np.ndarray]:
    """Return the rows of loads one after the other, named in the column LOAD_CASE; those of "" as they are.

    What only the first has is NaN in the others' rows, or empty text.
    """
    first, *others = columns.values()
    if not others and "" in columns:
        return first
    joined = {LOAD_CASE: np.repeat(np.array(list(columns), object), len(first["node"]))}
    for key, own in first.items():
        none = np.full(own.shape, "", object) if own.dtype == object else np.full(own.shape, np.nan)
        joined[key] = np.concatenate([part.get(key, none) for part in columns.values()])
    return joined


def read_front(path: str | os.PathLike) -> dict[str, np.ndarray]:
    """Return the columns (k,) of numbers of a front by their names, at least x, y and z.

    Columns with text are left out. Raises CraftmeshError as `front_table` does, and for coordinates that
    are not finite numbers.
    """
    table = front_table(path)
    table.numbers("xyz")
    found = {name: table.column(name) for name in table.names if name}
    known = {name: name.casefold() for name in found if name.casefold() in _KNOWN}
    return {known.get(name, name): values for name, values in found.items() if values is not None}


def front_columns(
    path: str | os.PathLike,
    needed: Sequence[str],
    made: str,
    *known: Sequence[str],
    words: Sequence[str] = (),
) -> dict[str, np.ndarray]:
    """Return the columns of a front as `write_front` took them: `points`, and `needed` ones of numbers.

    known: groups of columns of numbers that are read where the whole group is there; words: columns of text
    that are read where they are there. Raises CraftmeshError that says how the file is `made`.
    """
    table = front_table(path)
    wanted = [*"xyz", *needed]
    try:
        rows = table.numbers(wanted) if table.rows or not table.has(wanted) else np.zeros((0, len(wanted)))
    except CraftmeshError as error:
        raise CraftmeshError(f"{error}; expected a file {made}") from None
    found = dict(zip(wanted, rows.T))
    for name in ["", *(name[:-1] for name in needed if name.endswith("_x"))]:
        parts = [found.pop(f"{name}{axis}") for axis in "xyz"]
        found[name.rstrip("_") or "points"] = np.stack(parts, axis=1)
    for names in known:
        if table.rows and table.has(names):
            found |= dict(zip(names, table.numbers(names).T))
    return found | {name: np.array(table.words(name), object) for name in words if table.has([name])}


def front_table(path: str | os.PathLike, axes: str = "xyz") -> Table:
    """Read a table with at least the columns of `axes`.

    A file without a header is taken as craftmesher's, with x, y, z in columns 7, 8, 9 counted from 0, or as
    bare x, y, z or `axes` when it has as many columns. Raises CraftmeshError for a missing file, missing
    columns and what `read_table` refuses.
    """
    table = read_table(path, axes)
    if not table.names:
        return bare_front(table, axes)
    loads = table.words(LOAD_CASE) or []
    kept = [row for row, name in enumerate(loads) if name == loads[0]]
    if not kept:
        return table
    return replace(table, rows=[table.rows[k] for k in kept], lines=[table.lines[k] for k in kept])


def bare_front(table: Table, axes: str = "xyz") -> Table:
    """Return a table without a header with the names of its coordinates, as `front_table` takes them."""
    width = len(table.rows[0])
    if width in (len(axes), 3):
        return table.named("xyz"[:width])
    if width < _CRAFTMESHER_XYZ + 3:
        raise CraftmeshError(
            f"{table.path}: {width} columns and no header; add a header that names {', '.join(axes)}"
        )
    return table.named((*[""] * _CRAFTMESHER_XYZ, *"xyz"))


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
