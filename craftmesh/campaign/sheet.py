"""The sheet of cases: rows, columns, lists of values, and the cases that come of them."""

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

# which files a deck consists of is asked before the cases are known; all run on one cluster, and one page
# shows all
WHOLE_CAMPAIGN = {"inp.includes", "node.cpus", "node.mem_mb", "report.quantity", "report.tolerance"}
LONGEST_VALUE = 24  # letters that a value may add to a case's name; longer ones are counted
COLUMNS = ("case", "microstructure", "crack", "increments")
OPTIONAL = ("growth",)  # a column that a sheet may have besides those


def case_keys(schema: Mapping[str, Any], config: Mapping[str, Any]) -> dict[str, dict]:
    """Return the schema of each key that a case may have to itself, by `section.key` or `cracks.NAME.key`.

    schema: the configuration's. config: one that fits it, whose cracks are those that have keys.
    """
    found: dict[str, dict] = {}
    for section, inner in schema["properties"].items():
        found |= {f"{section}.{key}": sub for key, sub in inner.get("properties", {}).items()}
    crack = schema["properties"]["cracks"]["additionalProperties"]["properties"]
    for name in config["cracks"]:
        found |= {f"cracks.{name}.{key}": sub for key, sub in crack.items()}
    return {key: sub for key, sub in found.items() if key not in WHOLE_CAMPAIGN}


def check_key(key: str, known: Mapping[str, Any], place: str) -> None:
    """Raise CraftmeshError, beginning with `place`, unless a case may have `key` to itself."""
    if key in known:
        return
    if key in WHOLE_CAMPAIGN:
        raise CraftmeshError(f"{place}: {key} holds for all cases; set it in the configuration")
    near = get_close_matches(key, known, 1)
    hint = f"did you mean {near[0]!r}?" if near else "expected section.key, such as sizing.l_min"
    raise CraftmeshError(f"{place}: unknown key {key!r}; {hint}")


def cell_value(text: str, schema: Mapping[str, Any], place: str) -> Any:
    """Return the value of a cell, which is read as YAML, like a value in the configuration.

    schema: of the cell's key. A key of texts gets the words as written, numbers, dates, yes and no too.
    """
    import yaml

    try:
        words = yaml.load(text, yaml.BaseLoader)
    except yaml.YAMLError:
        raise CraftmeshError(f"{place} is {text!r}; expected a value as in the configuration") from None
    try:
        return _as_written(parse_yaml(text, place), words, schema)
    except CraftmeshError:
        several = words if isinstance(words, list) and "array" not in kinds_of(schema) else [words]
        if all(is_valid(filled(word, schema), schema) for word in several):  # 0012, a name or 12
            return words
        raise


def _as_written(value: Any, words: Any, schema: Mapping[str, Any]) -> Any:
    """Return `value`, or `words`, the same with texts alone, where only these fit the schema."""
    if value is None or is_valid(filled(value, schema), schema):
        return value
    if isinstance(value, list) and not is_valid(words, schema):
        return [_as_written(*item, schema) for item in zip(value, words)]
    return words if is_valid(words, schema) else value


@dataclass(frozen=True)
class Choice:
    """The values that a row has for one key; a list of values (`swept`) is in the names of its cases."""

    values: Sequence[Any]
    swept: bool = False


def choice(value: Any, schema: Mapping[str, Any], place: str) -> Choice:
    """Return the values of a key in one cell: its own, or those of a list that is no value of the key."""
    value = filled(value, schema)
    takes_lists = "array" in kinds_of(schema)
    if not isinstance(value, list) or (takes_lists and is_valid(value, schema)):
        return Choice([value])
    if takes_lists and not all(isinstance(item, list) for item in value):
        return Choice([value])
    if not value:
        raise CraftmeshError(f"{place} is an empty list; expected a value or several")
    return Choice([filled(item, schema) for item in value], swept=True)


def variants(name: str, cells: Mapping[str, Choice]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the name and the value of every key for each case that comes of one row.

    A row without swept keys is one case under the row's name; otherwise every value of each key goes with
    every value of the others, and the name is followed by the swept keys and their values.
    """
    swept = [key for key, cell in cells.items() if cell.swept]
    last = [key.rpartition(".")[2] for key in swept]
    titles = {key: key if last.count(short) > 1 else short for key, short in zip(swept, last)}
    for numbered in itertools.product(*(enumerate(cell.values, 1) for cell in cells.values())):
        chosen = dict(zip(cells, numbered))
        parts = [f"{titles[key]}-{_word(*chosen[key])}" for key in swept]
        yield "-".join([name, *parts]), {key: value for key, (_, value) in chosen.items()}


def _word(number: int, value: Any) -> str:
    """Return a value as part of a folder's name, or its number in the list where that would be long."""
    word = as_case_name(_text(value))
    return word if 0 < len(word) <= LONGEST_VALUE else str(number)


def _text(value: Any) -> str:
    if isinstance(value, list):
        return "_".join(map(_text, value))
    if value is None or isinstance(value, bool):
        return {None: "none", True: "true", False: "false"}[value]
    return str(value)


def laid_over(config: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of `config` with the values of the keys of `case_keys` in place of its own."""
    made = {**config, "cracks": dict(config["cracks"])}
    for path, value in changes.items():
        inner, _, key = path.rpartition(".")
        section, _, name = inner.partition(".")
        holder = made[section] if name else made
        holder[name or section] = {**holder[name or section], key: value}
    return made


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
    if not path.exists():
        raise CraftmeshError(f"cases: {path} is not there; expected a sheet with {listed(COLUMNS)}")
    swept = _sweep(rules)
    rows = read_rows(path)
    for _, cells in rows:
        while len(cells) > 1 and not cells[-1]:  # spreadsheets leave them
            cells.pop()
    columns = _columns(rows[0][1], rules.keys) if rows else []
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


def _columns(heads: Sequence[str], known: Mapping[str, Any]) -> list[str]:
    """Return the columns that heads mean, whose capitals count only where two columns differ in them."""
    meant = [*COLUMNS, *OPTIONAL, *known]
    by_small: dict[str, list[str]] = {}
    for name in meant:
        by_small.setdefault(name.casefold(), []).append(name)
    near = [by_small.get(re.sub(r"\s*\.\s*", ".", head).casefold(), []) for head in heads]
    return [names[0] if head not in meant and len(names) == 1 else head for head, names in zip(heads, near)]


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
    """Return the configuration with a case's changes; they alone are held against the schema, for speed."""
    made = laid_over(rules.config, changes)
    if not all(is_valid(value, rules.keys[key]) for key, value in changes.items()):
        with named(place):
            completed(made, rules.schema)  # says which key
    return made


def _choices(
    cells: Mapping[str, str], known: Mapping[str, dict], row: Mapping[str, dict], place: str
) -> dict[str, Choice]:
    """Return what a row's cells say, but for its name and empty cells of keys."""
    found = {}
    for column, text in cells.items():
        at = f"{place}, column {column}"
        if column in known and text:
            found[column] = choice(cell_value(text, known[column], at), known[column], at)
        elif column in COLUMNS[1:] or (column in OPTIONAL and text):
            own = row[column]
            found[column] = choice(cell_value(text, own, at) if text[:1] == "[" else text, own, at)
    return found
