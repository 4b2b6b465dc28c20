"""The reader of all text tables, as spreadsheets and other programs write them.

The separator is the first of tab, semicolon, comma and blank that the header contains. A comma in a cell is
a decimal mark; a table has only one kind of decimal mark. Column names may have capitals, and a unit in
brackets after them. Lines that begin with # or // are comments. Text is UTF-8, or UTF-16 with a byte order
mark.
"""

import codecs
import csv
import os
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from craftmesh.errors import CraftmeshError, existing_file

TITLE_LINES = 3  # largest number of lines above the header, as in tables of Avizo
_HEAD = re.compile(r"(.*?)\s*(?:[(\[]\s*([^)\]]*?)\s*[)\]])?")  # a column's name, and its unit in brackets
_MICRO = str.maketrans("\u00b5\u03bc", "uu")  # both characters for micro count as u
_DECIMAL_COMMAS = "; save numbers with points, or with semicolons between the columns"


@dataclass(frozen=True, eq=False)
class Table:
    """A table of text cells.

    names: names of the columns, empty if the file has no header; units: their units, "" if not given; rows:
    cells, one per column in each row; lines: line number of each row in the file, from 1. Names are
    compared without regard to capitals.
    """

    path: str | os.PathLike
    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: list[list[str]]
    lines: list[int]

    def named(self, names: Sequence[str]) -> "Table":
        """Return the table with `names` for its first columns, and "" for the others."""
        rest = len(self.rows[0]) - len(names)
        return replace(self, names=(*names, *[""] * rest), units=("",) * len(self.rows[0]))

    def has(self, names: Collection[str]) -> bool:
        """Return True if the table has columns with all these names, which are in lower case."""
        return set(names) <= {own.casefold() for own in self.names}

    def words(self, name: str) -> list[str] | None:
        """Return the cells of a column; None if there is no such column."""
        return [row[self._place(name)] for row in self.rows] if self.has([name]) else None

    def column(self, name: str) -> np.ndarray | None:
        """Return a column (k,) as numbers, NaN for "nan"; None if another cell is not a number.

        Raises CraftmeshError if the column has decimal commas and the table also decimal points.
        """
        at = self._place(name)
        try:
            return np.array([row[at] for row in self.rows], float)
        except ValueError:
            numbers = np.array([_number(row[at]) for row in self.rows])
        if not all(np.isfinite(numbers) | np.array([row[at].casefold() == "nan" for row in self.rows])):
            return None
        for line, row in zip(self.lines, self.rows):
            if any("." in cell and _is_number(cell) for cell in row):
                raise CraftmeshError(
                    f"{self.path}, line {line}: has a decimal point, but column {name} has decimal commas; "
                    f"expected the same mark in all numbers{_DECIMAL_COMMAS}"
                )
        return numbers

    def numbers(self, names: Sequence[str]) -> np.ndarray:
        """Return the columns `names` as finite numbers (k, n).

        Raises CraftmeshError for a missing column, columns of different units, a table without rows, and a
        cell that is not a finite number.
        """
        missing = [name for name in names if not self.has([name])]
        if missing:
            raise CraftmeshError(
                f"{self.path}: no column {missing[0]!r} (found: {', '.join(self.names)}); the header must "
                f"name {', '.join(names)}"
            )
        units = {name: self.units[self._place(name)] for name in names}
        if len({unit.translate(_MICRO).casefold() for unit in units.values() if unit}) > 1:
            told = ", ".join(f"{name} [{unit}]" for name, unit in units.items())
            raise CraftmeshError(f"{self.path}: columns {told} differ in unit; use one unit for all")
        if not self.rows:
            raise CraftmeshError(f"{self.path}: no row below the header; add at least one point")
        columns = [self.column(name) for name in names]
        for name, column in zip(names, columns):
            if column is None or not np.isfinite(column).all():
                raise self._not_finite(name)
        return np.column_stack([column for column in columns if column is not None])

    def _place(self, name: str) -> int:
        return [own.casefold() for own in self.names].index(name.casefold())

    def _not_finite(self, name: str) -> CraftmeshError:
        cells = [row[self._place(name)] for row in self.rows]
        at = next(i for i, cell in enumerate(cells) if not np.isfinite(_number(cell)))
        return CraftmeshError(
            f"{self.path}, line {self.lines[at]}: {name} is {cells[at]!r}; expected a finite number"
        )


def read_table(path: str | os.PathLike, *kinds: Sequence[str]) -> Table:
    """Return the table in a text file.

    kinds: groups of column names in lower case; a line with all names of a group is the header. It may have
    up to 3 lines of titles above it. If there is no such line, a first line with text is the header, else a
    comment with all names of a group; else the table has no header. Raises CraftmeshError for missing,
    empty or binary files, for duplicate names, and for rows longer or shorter than the header.
    """
    lines, comments = _lines(path)
    if not lines:
        raise CraftmeshError(f"{path}: is empty; give a table with the columns {', '.join(kinds[-1])}")
    wanted = [set(kind) for kind in kinds]
    for skipped, (_, line) in enumerate(lines[: TITLE_LINES + 1]):
        heads = _heads(line)
        if any(kind <= {name.casefold() for name, _ in heads} for kind in wanted):
            return _table(path, heads, lines[skipped + 1 :], _separator(line))
    first = lines[0][1]
    separator = _separator(first)
    if not all(map(_is_number, _cells(path, [lines[0]], separator)[0])):
        return _table(path, _heads(first), lines[1:], separator)
    for heads in map(_heads, comments):
        if any(kind <= {name.casefold() for name, _ in heads} for kind in wanted):
            return _table(path, heads, lines, separator)
    return _table(path, [], lines, separator)


def read_rows(path: str | os.PathLike) -> list[tuple[int, list[str]]]:
    """Return line number and cells of each line except comments; the first line sets the separator."""
    lines, _ = _lines(path)
    rows = _cells(path, lines, _separator(lines[0][1])) if lines else []
    return [(number, row) for (number, _), row in zip(lines, rows)]


def _lines(path: str | os.PathLike) -> tuple[list[tuple[int, str]], list[str]]:
    """Return the numbered non-empty lines of a file, without comments, and the texts of its comments."""
    content = existing_file(path, "expected a table as text").read_bytes()
    is_wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    text = content.decode("utf-16" if is_wide else "utf-8-sig", errors="replace")
    if "\0" in text:
        raise CraftmeshError(f"{path}: is not a text file; save the table as text, .csv in UTF-8")
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip(' ,;\t"')]
    is_comment = [line.lstrip().startswith(("#", "//")) for _, line in lines]
    comments = [line.strip(" \t#/") for (_, line), apart in zip(lines, is_comment) if apart]
    return [line for line, apart in zip(lines, is_comment) if not apart], comments


def _separator(line: str) -> str:
    """Return the separator of a line's cells; "" for blanks, and for a line of only numbers and blanks."""
    words = line.split()
    is_bare = len(words) > 1 and all(map(_is_number, words))
    return "" if is_bare else next((mark for mark in "\t;," if mark in line), "")


def _cells(path: str | os.PathLike, lines: list[tuple[int, str]], separator: str) -> list[list[str]]:
    """Return the cells of each numbered line; raises CraftmeshError for quotation marks left open."""
    if not separator:
        return [[cell.strip('"') for cell in re.findall(r'"[^"]*"|\S+', line)] for _, line in lines]
    try:
        found = list(csv.reader((line for _, line in lines), delimiter=separator, skipinitialspace=True))
    except csv.Error as error:
        raise CraftmeshError(f"{path}: cannot be read as a table ({error}); save it as .csv") from None
    if len(found) != len(lines):
        raise CraftmeshError(f"{path}: a quotation mark is not closed on its line; close or remove it")
    return [[cell.strip() for cell in row] for row in found]


def _heads(line: str) -> list[tuple[str, str]]:
    """Return the names and units in a header line, for example x and um of `x [um]`."""
    joined = re.sub(r"\s+(?=[(\[])", "", line)
    cells = _cells("", [(0, joined)], _separator(joined))[0] if joined.count('"') % 2 == 0 else [joined]
    while cells and not cells[-1]:
        cells.pop()
    return [(match[1], match[2] or "") for match in map(_HEAD.fullmatch, cells) if match]


def _table(
    path: str | os.PathLike, heads: list[tuple[str, str]], lines: list[tuple[int, str]], separator: str
) -> Table:
    rows = _cells(path, lines, separator)
    width = len(heads) or len(rows[0])
    for (number, _), row in zip(lines, rows):
        if len(row) != width and (len(row) < width or any(row[width:])):
            hint = _DECIMAL_COMMAS if separator == "," else ""
            raise CraftmeshError(f"{path}, line {number}: has {len(row)} cells; expected {width}{hint}")
    names = [name.casefold() for name, _ in heads if name]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise CraftmeshError(f"{path}: duplicate column name {twice!r}; use each name once")
    rows = [row[:width] for row in rows]
    return Table(
        path,
        tuple(name for name, _ in heads),
        tuple(unit for _, unit in heads),
        rows,
        [number for number, _ in lines],
    )


def _number(cell: str) -> float:
    """Return the number in a cell, also with a decimal comma; NaN if it is not a number."""
    try:
        return float(cell if "." in cell or cell.endswith(",") else cell.replace(",", "."))
    except ValueError:
        return float("nan")


def _is_number(cell: str) -> bool:
    return np.isfinite(_number(cell)) or cell.casefold() == "nan"
