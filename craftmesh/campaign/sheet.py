"""The case table: its rows, columns and lists of values, and the cases made from them."""

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any

from craftmesh.campaign.cases import Case, as_case_name, check_capitals, check_case_name
from craftmesh.campaign.configuration import completed, filled, is_valid, kinds_of
from craftmesh.errors import CraftmeshError, listed, named
from craftmesh.io.text_table import read_rows
from craftmesh.io.yaml_file import parse_yaml

# Keys that no single case may set: the deck's files must be known before the cases, and all cases share one
# cluster and one report.
WHOLE_CAMPAIGN = {"inp.includes", "node.cpus", "node.mem_mb", "report.quantity", "report.tolerance"}
LONGEST_VALUE = 24  # letters of a value in a case's name; a longer value is replaced by its number
COLUMNS = ("case", "microstructure", "crack", "increments")
OPTIONAL = ("growth",)  # further columns that a case table may have


def case_keys(schema: Mapping[str, Any], config: Mapping[str, Any]) -> dict[str, dict]:
    """Return the schema of each key that a case may set, by `section.key` or `cracks.NAME.key`.

    schema: the configuration's schema; config: a valid configuration, which has the names of cracks.
    """
    found: dict[str, dict] = {}
    for section, inner in schema["properties"].items():
        found |= {f"{section}.{key}": sub for key, sub in inner.get("properties", {}).items()}
    crack = schema["properties"]["cracks"]["additionalProperties"]["properties"]
    for name in config["cracks"]:
        found |= {f"cracks.{name}.{key}": sub for key, sub in crack.items()}
    return {key: sub for key, sub in found.items() if key not in WHOLE_CAMPAIGN}


def check_key(key: str, known: Mapping[str, Any], place: str) -> None:
    """Raise CraftmeshError, beginning with `place`, unless a case may set `key`, one of `known`."""
    if key in known:
        return
    if key in WHOLE_CAMPAIGN:
        raise CraftmeshError(f"{place}: {key} applies to all cases; set it in the configuration file")
    near = get_close_matches(key, known, 1)
    hint = f"did you mean {near[0]!r}?" if near else "expected section.key, such as sizing.l_min"
    raise CraftmeshError(f"{place}: unknown key {key!r}; {hint}")


def cell_value(text: str, schema: Mapping[str, Any], place: str) -> Any:
    """Return the value of a cell, whose `text` is read as YAML, like a value in the configuration.

    schema: the schema of the cell's key. If the key takes text, numbers, dates, yes and no stay as written.
    place: begins the message of a CraftmeshError for text that is not YAML.
    """
    import yaml

    try:
        words = yaml.load(text, yaml.BaseLoader)
    except yaml.YAMLError:
        raise CraftmeshError(f"{place} is {text!r}; write a valid YAML value") from None
    try:
        return _as_written(parse_yaml(text, place), words, schema)
    except CraftmeshError:
        several = words if isinstance(words, list) and "array" not in kinds_of(schema) else [words]
        if all(is_valid(filled(word, schema), schema) for word in several):  # as text 0012 may be valid
            return words
        raise


def _as_written(value: Any, words: Any, schema: Mapping[str, Any]) -> Any:
    """Return `value`, or `words`, the same cell with all scalars as text, if only this fits the schema."""
    if value is None or is_valid(filled(value, schema), schema):
        return value
    if isinstance(value, list) and not is_valid(words, schema):
        return [_as_written(*item, schema) for item in zip(value, words)]
    return words if is_valid(words, schema) else value


@dataclass(frozen=True)
class Choice:
    """The values of one key in a row.

    swept: True if each value makes a case of its own, which has the value in its name.
    """

    values: Sequence[Any]
    swept: bool = False


def choice(value: Any, schema: Mapping[str, Any], place: str) -> Choice:
    """Return the values of a key in one cell: the items of a list, or the one value of any other cell.

    If the key takes lists, a list is one value, except a list of lists that its schema rejects. Raises
    CraftmeshError, beginning with `place`, for an empty list of values.
    """
    value = filled(value, schema)
    takes_lists = "array" in kinds_of(schema)
    if not isinstance(value, list) or (takes_lists and is_valid(value, schema)):
        return Choice([value])
    if takes_lists and not all(isinstance(item, list) for item in value):
        return Choice([value])
    if not value:
        raise CraftmeshError(f"{place} is an empty list; give at least one value")
    return Choice([filled(item, schema) for item in value], swept=True)


def variants(name: str, cells: Mapping[str, Choice]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the name of each case made from one row, and its value of every key.

    name: the row's case name; cells: values by column or key. A row without swept keys is one case with the
    row's name. Otherwise all combinations of values are cases; their names end in the swept keys and
    values.
    """
    swept = [key for key, cell in cells.items() if cell.swept]
    last = [key.rpartition(".")[2] for key in swept]
    titles = {key: key if last.count(short) > 1 else short for key, short in zip(swept, last)}
    for numbered in itertools.product(*(enumerate(cell.values, 1) for cell in cells.values())):
        chosen = dict(zip(cells, numbered))
        parts = [f"{titles[key]}-{_word(*chosen[key])}" for key in swept]
        yield "-".join([name, *parts]), {key: value for key, (_, value) in chosen.items()}


def _word(number: int, value: Any) -> str:
    """Return a value as part of a folder's name; its `number` in the list if it is empty or too long."""
    word = as_case_name(_text(value))
    return word if 0 < len(word) <= LONGEST_VALUE else str(number)


def _text(value: Any) -> str:
    if isinstance(value, list):
        return "_".join(map(_text, value))
    if value is None or isinstance(value, bool):
        return {None: "none", True: "true", False: "false"}[value]
    return str(value)


def laid_over(config: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of `config` updated with `changes`, by `section.key` or `cracks.NAME.key`."""
    made = {**config, "cracks": dict(config["cracks"])}
    for path, value in changes.items():
        inner, _, key = path.rpartition(".")
        section, _, name = inner.partition(".")
        holder = made[section] if name else made
        holder[name or section] = {**holder[name or section], key: value}
    return made


@dataclass(frozen=True)
class Rules:
    """The schemas and the configuration by which the rows of a case table are checked.

    row: schema of a row; schema: schema of the configuration; config: the campaign's checked configuration.
    """

    row: dict
    schema: dict
    config: Mapping[str, Any]

    @cached_property
    def keys(self) -> dict[str, dict]:
        """The schema of each key that a case may set."""
        return case_keys(self.schema, self.config)


def read_cases(path: Path, rules: Rules) -> dict[str, Case]:
    """Return the cases of a case table, a text file, by name; lines that start with # are comments.

    A column `section.key` sets this key for each case. Where its cell is empty, or missing at the end of a
    line, the configuration's value is used. A list of values, in a cell or in the configuration's `sweep`,
    makes one case per value. Raises CraftmeshError, which names the file and, if known, the line and case,
    for a missing file, wrong columns, invalid values, and invalid or duplicate case names.
    """
    if not path.exists():
        raise CraftmeshError(f"cases: {path} does not exist; give a table with columns {listed(COLUMNS)}")
    swept = _sweep(rules)
    rows = read_rows(path)
    for _, cells in rows:
        while len(cells) > 1 and not cells[-1]:  # empty cells that spreadsheets write
            cells.pop()
    columns = _columns(rows[0][1], rules.keys) if rows else []
    _check_columns(columns, rules.keys, str(path))
    cases: dict[str, Case] = {}
    for number, row in rows[1:]:
        place = f"{path}, line {number}"
        lacking = columns[len(row) :]
        if len(row) > len(columns) or set(lacking) & set(COLUMNS):
            raise CraftmeshError(
                f"{place}, case {row[0]!r}: {len(row)} cells; expected {len(columns)}: {listed(columns)}"
            )
        if any("\ufffd" in cell for cell in row):
            raise CraftmeshError(f"{place}: not valid UTF-8; save the file as UTF-8")
        for case in _cases(dict(zip(columns, row + [""] * len(lacking))), swept, rules, place):
            if case.name in cases:
                raise CraftmeshError(f"{place}: duplicate case name {case.name!r}; use different names")
            cases[case.name] = case
    if not cases:
        raise CraftmeshError(f"{path}: contains no case; add at least one row below the header")
    check_capitals(cases, str(path))
    return cases


def _sweep(rules: Rules) -> dict[str, Choice]:
    """Return the values of each key in the configuration's `sweep`, checked like the key's own value."""
    swept = {}
    for key, values in rules.config["sweep"].items():
        check_key(key, rules.keys, "sweep")
        kept = [filled(value, rules.keys[key]) for value in values]
        for value in kept:
            _settings({key: value}, rules, "sweep")
        swept[key] = Choice(kept, swept=True)
    return swept


def _columns(heads: Sequence[str], known: Mapping[str, Any]) -> list[str]:
    """Return the column names that `heads` mean: capitals and spaces around dots do not matter.

    Capitals matter only if two known names differ in nothing else. Unknown heads are returned unchanged.
    """
    meant = [*COLUMNS, *OPTIONAL, *known]
    by_small: dict[str, list[str]] = {}
    for name in meant:
        by_small.setdefault(name.casefold(), []).append(name)
    near = [by_small.get(re.sub(r"\s*\.\s*", ".", head).casefold(), []) for head in heads]
    return [names[0] if head not in meant and len(names) == 1 else head for head, names in zip(heads, near)]


def _check_columns(columns: Sequence[str], known: Mapping[str, Any], place: str) -> None:
    if not set(COLUMNS) <= set(columns) or len(set(columns)) < len(columns):
        raise CraftmeshError(
            f"{place}: columns {listed(columns)}; expected {listed(COLUMNS)}, optionally "
            f"{listed(OPTIONAL)} and section.key, each once"
        )
    for column in columns:
        if column not in COLUMNS + OPTIONAL:
            check_key(column, known, f"{place}, column {column}")


def _cases(
    cells: Mapping[str, str], swept: Mapping[str, Choice], rules: Rules, place: str
) -> Iterator[Case]:
    """Yield the cases of one row; a non-empty cell overrides a sweep of the same key."""
    row = cells["case"]
    choices = {**swept, **_choices(cells, rules.keys, rules.row["properties"], f"{place}, case {row!r}")}
    for name, values in variants(row, choices):
        at = f"{place}, case {name!r}"
        changes = {key: value for key, value in values.items() if key in rules.keys}
        columns = {key: value for key, value in values.items() if key not in rules.keys}
        with named(at):
            columns = completed({"case": name} | columns, rules.row)
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
    """Return the configuration updated with a case's changes.

    For speed, only the changes are validated. Raises CraftmeshError, beginning with `place`, for invalid
    values.
    """
    made = laid_over(rules.config, changes)
    if not all(is_valid(value, rules.keys[key]) for key, value in changes.items()):
        with named(place):
            completed(made, rules.schema)  # raises an error that names the key
    return made


def _choices(
    cells: Mapping[str, str], known: Mapping[str, dict], row: Mapping[str, dict], place: str
) -> dict[str, Choice]:
    """Return the values of a row's cells by column, except its name and empty optional cells."""
    found = {}
    for column, text in cells.items():
        at = f"{place}, column {column}"
        if column in known and text:
            found[column] = choice(cell_value(text, known[column], at), known[column], at)
        elif column in COLUMNS[1:] or (column in OPTIONAL and text):
            own = row[column]
            found[column] = choice(cell_value(text, own, at) if text[:1] == "[" else text, own, at)
    return found
