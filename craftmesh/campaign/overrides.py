"""Keys of the configuration that hold for single cases: columns `section.key` of the sheet, and sweeps."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from craftmesh.campaign.case_names import as_case_name
from craftmesh.campaign.configuration import filled, is_valid, kinds_of
from craftmesh.errors import CraftmeshError

# which files a deck consists of is asked before the cases are known; all run on one cluster, and one page
# shows all
WHOLE_CAMPAIGN = {"inp.includes", "node.cpus", "node.mem_mb", "report.quantity", "report.tolerance"}
LONGEST_VALUE = 24  # letters that a value may add to a case's name; longer ones are counted


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


def cell_value(text: str, place: str) -> Any:
    """Return what a cell says, read as a value in the configuration is."""
    import yaml

    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        raise CraftmeshError(f"{place} is {text!r}; expected a value as in the configuration") from None


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
