"""Crack fronts as .csv files whose header names x, y, z."""

import csv
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.io.text_table import Table, read_table

_CRAFTMESHER_XYZ = 7  # index of the first of the columns x, y, z
# Column of load case names. A front's rows are repeated for each; readers use only the first load case.
LOAD_CASE = "load_case"
_KNOWN = {"x", "y", "z", "front", "closed"}


def write_front(path: str | os.PathLike, columns: Mapping[str, np.ndarray]) -> None:
    """Write one row per front node, in order; an array (k, 3) becomes `name_x`, `name_y`, `name_z`.

    The array `points` (k, 3) becomes x, y, z. Floats keep every bit; integers stay integers.
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
    """Return one table with the rows of all load cases, case by case, and their names in LOAD_CASE.

    columns: load case -> columns by name, the same number of rows in each. A single load case "" is
    returned unchanged. Columns that only the first load case has are NaN, or empty text, in other rows.
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
    """Return the numeric columns (k,) of a front's first load case by name, at least x, y and z.

    Columns with text are left out. Raises CraftmeshError for a missing or malformed table, as
    `front_table`, and for coordinates that are not finite numbers.
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
    gaps: Sequence[str] = (),
) -> dict[str, np.ndarray]:
    """Return the arrays of a front by name, in the form that `write_front` takes.

    `points` (k, 3) come from x, y, z, and an array NAME (k, 3) from columns NAME_x, NAME_y, NAME_z.
    needed: numeric columns that must exist; known: groups of optional numeric columns, read if the whole
    group exists; words: optional text columns; gaps: optional numeric columns, NaN where unknown; made: how
    the file is made, for errors. Raises CraftmeshError for a missing file or column, and for other numbers
    that are not finite.
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
    found |= {name: np.array(table.words(name), object) for name in words if table.has([name])}
    partly = {name: table.column(name) for name in gaps if table.rows and table.has([name.casefold()])}
    return found | {name: column for name, column in partly.items() if column is not None}


def front_table(path: str | os.PathLike, axes: str = "xyz") -> Table:
    """Return the table of a front; of several load cases, only the first one's rows.

    axes: column names by which the header is found. A file without a header gets names by the number of
    its columns, as in `bare_front`. Raises CraftmeshError for missing or malformed tables, as `read_table`,
    and for files without a header that have too few columns.
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
    """Give names to the coordinate columns of a table without header, and return the table.

    If it has three columns, or as many as `axes`, they are x, y, z. Otherwise the file is taken as
    craftmesher's (an earlier program), with x, y, z in columns 7, 8, 9 counted from 0. Raises
    CraftmeshError for fewer columns.
    """
    width = len(table.rows[0])
    if width in (len(axes), 3):
        return table.named("xyz"[:width])
    if width < _CRAFTMESHER_XYZ + 3:
        raise CraftmeshError(
            f"{table.path}: {width} columns but no header; add a header that names {', '.join(axes)}"
        )
    return table.named((*[""] * _CRAFTMESHER_XYZ, *"xyz"))


def read_fronts(path: str | os.PathLike) -> list[np.ndarray]:
    """Return the fronts of a file as polylines (k, 3), points in the file's order; errors as `read_front`.

    The column `front`, as in front.csv, numbers the fronts; without it there is one. The first point of a
    front is repeated at its end if the column `closed` is 1 at a point and the end points differ.
    """
    columns = read_front(path)
    points = np.stack([columns[axis] for axis in "xyz"], axis=1)
    number, closed = (columns.get(name, np.zeros(len(points))) for name in ("front", "closed"))
    fronts = []
    for own in (number == k for k in np.unique(number)):
        ring = closed[own].any() and (points[own][0] != points[own][-1]).any()
        fronts.append(np.concatenate([points[own], points[own][:1]]) if ring else points[own])
    return fronts
