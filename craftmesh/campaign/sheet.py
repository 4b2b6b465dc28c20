"""The sheet of cases: rows, columns, and the cases that come of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from craftmesh.campaign.case_names import check_capitals, check_case_name
from craftmesh.campaign.cases import Case
from craftmesh.campaign.configuration import completed, filled, is_valid
from craftmesh.campaign.overrides import (
    Choice,
    case_keys,
    cell_value,
    check_key,
    choice,
    laid_over,
    variants,
)
from craftmesh.errors import CraftmeshError, listed
from craftmesh.io.text_table import read_rows

COLUMNS = ("case", "microstructure", "crack", "increments")
OPTIONAL = ("growth",)  # a column that a sheet may have besides those


@dataclass(frozen=True)
class Rules:
    """What rows are held against: the schemas of a row and of the configuration, and that, checked."""

    row: dict
    schema: dict
    config: Mapping[str, Any]

    @cached_property
    def keys(self) -> dict[str, dict]:
        """The schemas of the keys that a case may have to itself."""
        return case_keys(self.schema, self.config)


def read_cases(path: Path, rules: Rules) -> dict[str, Case]:
    """Read the sheet of cases, a table as text; lines that start with # are left out.

    A column `section.key` has the key's value for each case; where the cell is empty, or missing at the end
    of a line, the configuration's holds. A list of values, there or under the configuration's `sweep`,
    makes a case of each.
    Raises CraftmeshError that names the file, and the line and the case where they matter.
    """
    if not path.is_file():
        raise CraftmeshError(f"cases: {path} is not there; expected a sheet with {listed(COLUMNS)}")
    swept = _sweep(rules)
    rows = [(number, _without_last_empty(cells)) for number, cells in read_rows(path)]
    columns = rows[0][1] if rows else []
    _check_columns(columns, rules.keys, str(path))
    cases: dict[str, Case] = {}
    for number, row in rows[1:]:
        place = f"{path}, line {number}"
        lacking = columns[len(row) :]
        if len(row) > len(columns) or set(lacking) & set(COLUMNS):
            raise CraftmeshError(
                f"{place}, case {row[0]!r}: {len(row)} columns; expected {len(columns)}, {listed(columns)}"
            )
        if any("\ufffd" in cell for cell in row):
            raise CraftmeshError(f"{place}: letters that are not UTF-8; expected text saved as UTF-8")
        for case in _cases(dict(zip(columns, row + [""] * len(lacking))), swept, rules, place):
            if case.name in cases:
                raise CraftmeshError(f"{place}: case {case.name!r} is there twice; names must differ")
            cases[case.name] = case
    if not cases:
        raise CraftmeshError(f"{path}: no case; expected at least one row under the header")
    check_capitals(cases, str(path))
    return cases


def _without_last_empty(cells: list[str]) -> list[str]:
    """Return the cells of a line without the empty ones that spreadsheets leave at its end."""
    while len(cells) > 1 and not cells[-1]:
        cells = cells[:-1]
    return cells


def _sweep(rules: Rules) -> dict[str, Choice]:
    """Return the values of the configuration's sweep, each checked as the key itself."""
    swept = {}
    for key, values in rules.config["sweep"].items():
        check_key(key, rules.keys, "sweep")
        kept = [filled(value, rules.keys[key]) for value in values]
        for value in kept:
            _settings({key: value}, rules, "sweep")
        swept[key] = Choice(kept, swept=True)
    return swept


def _check_columns(columns: Sequence[str], known: Mapping[str, Any], place: str) -> None:
    if not set(COLUMNS) <= set(columns) or len(set(columns)) < len(columns):
        raise CraftmeshError(
            f"{place}: columns {listed(columns)}; expected {listed(COLUMNS)} and perhaps "
            f"{listed(OPTIONAL)} and section.key, each once"
        )
    for column in columns:
        if column not in COLUMNS + OPTIONAL:
            check_key(column, known, f"{place}, column {column}")


def _cases(
    cells: Mapping[str, str], swept: Mapping[str, Choice], rules: Rules, place: str
) -> Iterator[Case]:
    """Yield the cases of one row; a column's cell takes the place of a sweep of the same key."""
    row = cells["case"]
    choices = {**swept, **_choices(cells, rules.keys, f"{place}, case {row!r}")}
    for name, values in variants(row, choices):
        at = f"{place}, case {name!r}"
        changes = {key: value for key, value in values.items() if key in rules.keys}
        columns = {key: _counted(value) for key, value in values.items() if key not in rules.keys}
        columns = _checked({"case": name} | columns, rules.row, at)
        check_case_name(name, place)
        yield Case(
            columns.pop("case"),
            **columns,
            row=row,
            place=at,
            swept={key: value for key, value in values.items() if choices[key].swept},
            settings=_settings(changes, rules, at),
        )


def _settings(changes: Mapping[str, Any], rules: Rules, place: str) -> dict[str, Any]:
    """Return the configuration with a case's changes; they alone are held against the schema, for speed."""
    made = laid_over(rules.config, changes)
    if not all(is_valid(value, rules.keys[key]) for key, value in changes.items()):
        _checked(made, rules.schema, place)  # says which key
    return made


def _choices(cells: Mapping[str, str], known: Mapping[str, dict], place: str) -> dict[str, Choice]:
    """Return what a row's cells say, but for its name and empty cells of keys."""
    found = {}
    for column, text in cells.items():
        at = f"{place}, column {column}"
        if column in known and text:
            found[column] = choice(cell_value(text, at), known[column], at)
        elif column in COLUMNS[1:] or (column in OPTIONAL and text):
            is_list = text.startswith("[")
            found[column] = choice(cell_value(text, at), {}, at) if is_list else Choice([text])
    return found


def _counted(value: Any) -> Any:
    """Return a text of digits as a whole number."""
    return int(value) if isinstance(value, str) and value.isdecimal() else value


def _checked(values: Mapping[str, Any], schema: dict, place: str) -> dict:
    try:
        return completed(values, schema)
    except CraftmeshError as error:
        raise CraftmeshError(f"{place}: {error}") from None
