"""Validation of configurations with their JSON schema: fill in defaults, report the first fault."""

import re
import reprlib
from collections.abc import Mapping
from dataclasses import fields
from datetime import date
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError, listed
from craftmesh.extras import extra
from craftmesh.options import BOUNDS, is_admitted

# Pattern of all numbers in text. YAML 1.1 reads some as text, such as 4e-6, which has no decimal point.
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")


def load_schema(path: Path) -> dict:
    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # faster, because every job reads the schema
    return yaml.load(path.read_text(encoding="utf-8"), loader)  # noqa: S506 - both are safe


def completed(config: Mapping[str, Any], schema: dict) -> dict:
    """Return a copy of `config` with the schema's defaults, and text converted where numbers are expected.

    Raises CraftmeshError for the first fault, unknown keys before other faults.
    """
    try:
        _refuse_keys(config, "")
    except RecursionError:
        raise CraftmeshError("a YAML anchor contains itself; write its values out") from None
    made = filled(config, schema)
    faults = list(_validator()(schema).iter_errors(made))
    if faults:
        # unknown keys first, because an unknown key is often a misspelt required key
        faults.sort(
            key=lambda fault: (fault.validator != "additionalProperties", list(map(str, fault.path)))
        )
        raise CraftmeshError(_explain(faults[0]))
    return made


def _refuse_keys(value: Any, path: str) -> None:
    """Raise CraftmeshError for a key that YAML does not read as text, such as 12, no or 2024-01-31."""
    if isinstance(value, (list, tuple)):
        for item in value:
            _refuse_keys(item, path)
    if not isinstance(value, Mapping):
        return
    last: Any = None
    for key, inner in value.items():
        if not isinstance(key, str):
            advice = "put names that look like numbers, dates, yes or no in quotes"
            if inner is None and type(key) is type(last) is int:
                advice = f"a decimal comma? write {last}.{key}"
            place = path or "the configuration"
            raise CraftmeshError(f"{place} has the key {_shown(key)}, which is not text; {advice}")
        _refuse_keys(inner, f"{path}.{key}" if path else key)
        last = inner


def _shown(value: Any) -> str:
    """Return a value as text for error messages; very long integers are shortened in the middle."""
    if isinstance(value, int):
        return reprlib.repr(value)
    return str(value) if isinstance(value, date) else repr(value)


def is_valid(value: Any, schema: Mapping[str, Any]) -> bool:
    """Return True if `value` is valid under `schema`."""
    return _validator()(schema).is_valid(value)


@cache
def _validator() -> Any:
    """Return the JSON schema's validator, with numbers and integers checked as the option classes do.

    YAML has NaN and infinity, but JSON does not. A JSON schema accepts 4.0 as an integer, but the command
    line does not.
    """
    with extra("workflow"):
        from jsonschema import Draft202012Validator
        from jsonschema.validators import extend

    numbers = {
        "number": lambda _, value: is_admitted(value, float, {}),
        "integer": lambda _, value: is_admitted(value, int, {}),
    }
    return extend(
        Draft202012Validator, type_checker=Draft202012Validator.TYPE_CHECKER.redefine_many(numbers)
    )


def filled(value: Any, schema: Mapping[str, Any]) -> Any:
    """Return a copy of `value` with the schema's defaults, and text converted where a number is expected.

    Keys come in the schema's order, so that a configuration with reordered keys gives the same flags and
    nothing runs again.
    """
    if isinstance(value, (list, tuple)):
        return [filled(item, schema.get("items", {})) for item in value]
    if not isinstance(value, Mapping):
        return _number(value, kinds_of(schema))
    properties = schema.get("properties", {})
    made = {
        key: filled(value[key] if key in value else sub["default"], sub)
        for key, sub in properties.items()
        if key in value or "default" in sub
    }
    others = schema.get("additionalProperties") or {}
    return made | {key: filled(item, others) for key, item in value.items() if key not in properties}


def fields_of(options: type, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values in the section `keys` that belong to the option class `options`, by field name."""
    return {field.name: keys[field.name] for field in fields(options)}


def kinds_of(schema: Mapping[str, Any]) -> list[str]:
    """Return the names of the JSON types that a schema accepts."""
    kinds = schema.get("type", [])
    return [kinds] if isinstance(kinds, str) else kinds


def _number(value: Any, kinds: list[str]) -> Any:
    """Return a text as a number if it is one and the JSON types `kinds` accept it; else `value`."""
    if not isinstance(value, str) or not NUMBER.fullmatch(value):
        return value
    number = float(value)
    if "number" in kinds:
        return number
    return int(number) if "integer" in kinds and number.is_integer() else value


def _explain(fault: Any) -> str:
    """Return an error message of one line for a ValidationError of jsonschema."""
    path = ".".join(map(str, fault.absolute_path))
    if fault.validator == "additionalProperties":
        known = list(fault.schema.get("properties", {}))
        key = next(key for key in fault.instance if key not in known)
        near = get_close_matches(key, known, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"known: {listed(known)}"
        return f"unknown key {f'{path}.{key}' if path else key!r}; {hint}"
    if fault.validator == "required":
        key = next(key for key in fault.validator_value if key not in fault.instance)
        text = fault.schema["properties"][key].get("description", "")
        return f"key {f'{path}.{key}' if path else key} is missing; expected {text}"
    kinds, value, written = kinds_of(fault.schema), fault.instance, ""
    if isinstance(value, str) and {"number", "integer"} & set(kinds):
        is_comma = re.fullmatch(r"\s*[-+]?\d+,\d+\s*", value)
        written = f"; write {value.strip().replace(',', '.')}" if is_comma else ", written as 0.5 or 5e-7"
    elif "string" in kinds and isinstance(value, (bool, int, float, date)):
        written = "; put a name that looks like a number, a date, yes or no in quotes"
    expected = _expectation(fault.schema) + written
    return f"{path or 'the configuration'} is {_shown(value)}; expected {expected}"


def _expectation(schema: dict) -> str:
    if "enum" in schema:
        return "one of " + listed([value for value in schema["enum"] if value is not None])
    names = {
        "number": "a number",
        "integer": "a whole number",
        "string": "text",
        "boolean": "true or false",
    }
    names |= {"array": "a list", "object": "keys with values"}
    text = " or ".join(names[kind] for kind in kinds_of(schema) if kind != "null")
    if "minItems" in schema:
        least = "" if schema.get("maxItems") == schema["minItems"] else "at least "
        text += f" of {least}{schema['minItems']} values"
    limits = [(bound.sign, schema.get(bound.schema_key)) for bound in BOUNDS.values()]
    text += " and".join(f" {sign} {limit}" for sign, limit in limits if limit is not None)
    if "pattern" in schema:
        text += f" that fits {schema['pattern']}"
    about = schema.get("description")
    return f"{text} ({about})" if about else text
