"""Configurations held against their JSON schema: defaults filled in, the first fault told in one line."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError
from craftmesh.options import BOUNDS, is_admitted


def load_schema(path: Path) -> dict:
    import yaml

    return yaml.safe_load(path.read_text(encoding="utf-8"))


def completed(config: Mapping[str, Any], schema: dict) -> dict:
    """Return a copy of `config` with the schema's defaults; raises CraftmeshError for its first fault."""
    filled = _with_defaults(config, schema)
    faults = list(_validator()(schema).iter_errors(filled))
    if faults:
        # an unknown key explains more than the missing key that it was meant to be
        faults.sort(
            key=lambda fault: (fault.validator != "additionalProperties", list(map(str, fault.path)))
        )
        raise CraftmeshError(_explain(faults[0]))
    return filled


def is_valid(value: Any, schema: Mapping[str, Any]) -> bool:
    """True where `value` fits `schema`."""
    return _validator()(schema).is_valid(value)


@cache
def _validator() -> Any:
    """Return the JSON schema's validator with the numbers of the option classes.

    JSON knows no NaN and no infinity, but YAML does; and 4.0 is a whole number to a JSON schema, but not
    to the command line.
    """
    from jsonschema import Draft202012Validator
    from jsonschema.validators import extend

    numbers = {
        "number": lambda _, value: is_admitted(value, float, {}),
        "integer": lambda _, value: is_admitted(value, int, {}),
    }
    return extend(
        Draft202012Validator, type_checker=Draft202012Validator.TYPE_CHECKER.redefine_many(numbers)
    )


def _with_defaults(value: Any, schema: dict) -> Any:
    """Return a copy of `value` where objects have the defaults of their properties, in the schema's order.

    A configuration whose keys are only reordered gives the same flags, so that nothing runs again.
    """
    if not isinstance(value, Mapping):
        return list(value) if isinstance(value, tuple) else value
    properties = schema.get("properties", {})
    filled = {
        key: _with_defaults(value[key] if key in value else sub["default"], sub)
        for key, sub in properties.items()
        if key in value or "default" in sub
    }
    others = schema.get("additionalProperties") or {}
    return filled | {
        key: _with_defaults(item, others) for key, item in value.items() if key not in properties
    }


def _explain(fault: Any) -> str:
    """Return one line for a fault that jsonschema found."""
    path = ".".join(map(str, fault.absolute_path))
    if fault.validator == "additionalProperties":
        known = list(fault.schema.get("properties", {}))
        key = next(key for key in fault.instance if key not in known)
        near = get_close_matches(key, known, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"expected one of {listed(known)}"
        return f"unknown key {f'{path}.{key}' if path else key!r}; {hint}"
    if fault.validator == "required":
        key = next(key for key in fault.validator_value if key not in fault.instance)
        text = fault.schema["properties"][key].get("description", "")
        return f"key {f'{path}.{key}' if path else key} is missing; expected {text}"
    return f"{path or 'the configuration'} is {fault.instance!r}; expected {_expectation(fault.schema)}"


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
    kinds = schema.get("type", [])
    kinds = [kinds] if isinstance(kinds, str) else kinds
    text = " or ".join(names[kind] for kind in kinds if kind != "null")
    if "minItems" in schema:
        least = "" if schema.get("maxItems") == schema["minItems"] else "at least "
        text += f" of {least}{schema['minItems']} values"
    limits = [(bound.sign, schema.get(bound.schema_key)) for bound in BOUNDS.values()]
    text += " and".join(f" {sign} {limit}" for sign, limit in limits if limit is not None)
    if "pattern" in schema:
        text += f" that fits {schema['pattern']}"
    about = schema.get("description")
    return f"{text} ({about})" if about else text


def listed(names: Iterable) -> str:
    """Return names as one text, parted by commas."""
    return ", ".join(map(str, names))
