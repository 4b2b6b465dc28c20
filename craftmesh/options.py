"""Option fields of the stages' frozen dataclasses; library, command line and configuration share them."""

import importlib
import math
import operator
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, field, fields
from difflib import get_close_matches
from functools import cache
from numbers import Integral, Real
from typing import Any, NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError


class Bound(NamedTuple):
    """A kind of bound: its sign in messages, its key in a JSON schema, and its test holds(value, limit)."""

    sign: str
    schema_key: str
    holds: Callable[[Any, Any], bool]


BOUNDS = {
    "above": Bound(">", "exclusiveMinimum", operator.gt),
    "at_least": Bound(">=", "minimum", operator.ge),
    "below": Bound("<", "exclusiveMaximum", operator.lt),
    "at_most": Bound("<=", "maximum", operator.le),
}
_NAMES = {float: "number", int: "whole number", bool: "true or false", str: "text"}
_WITH_ARTICLE = (float, int)


def option(
    default: Any,
    help: str,
    unit: str = "",
    *,
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
    at_most: float | None = None,
) -> Any:
    """Return a dataclass field that carries its help text, unit and bounds; choices are typed as a Literal.

    `default` is MISSING if the user must give the value. A bound applies to each number of a tuple. The
    value None, where the type allows it, has no bounds.
    """
    bounds = {"above": above, "at_least": at_least, "below": below, "at_most": at_most}
    given = {name: limit for name, limit in bounds.items() if limit is not None}
    metadata = {"help": help, "unit": unit, "bounds": given}
    if default is MISSING:
        return field(metadata=metadata)
    return field(default=default, metadata=metadata)


class Options:
    """Base of the option classes: the constructor rejects values of a wrong type or out of bounds."""

    def __post_init__(self) -> None:
        """Raise CraftmeshError for the first field whose value its `option` does not allow."""
        hints = hints_of(type(self))  # type: ignore[arg-type]  # a class is hashable
        for item in fields(self):  # type: ignore[arg-type]  # those who inherit are dataclasses
            value, hint = getattr(self, item.name), hints[item.name]
            if not is_admitted(value, hint, item.metadata):
                shown = repr(value) if isinstance(value, str) else value
                expected = expectation(hint, item.metadata)
                raise CraftmeshError(f"{item.name} is {shown}; expected {expected}")


@cache
def hints_of(cls: type) -> dict[str, Any]:
    """Return the type hints of an option class by field name."""
    return typing.get_type_hints(cls)


def alternatives(hint: Any) -> tuple:
    """Return the types that a type hint allows: a union's members or the hint itself; str for a Literal."""
    return tuple(str if typing.get_origin(part) is typing.Literal else part for part in _members(hint))


def choices_of(hint: Any) -> tuple[str, ...]:
    """Return the values of the first Literal in a type hint; empty without one."""
    literals = (part for part in _members(hint) if typing.get_origin(part) is typing.Literal)
    return typing.get_args(next(literals, None))


def _members(hint: Any) -> tuple:
    is_union = isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union
    return typing.get_args(hint) if is_union else (hint,)


def items_of(hint: Any) -> tuple[Any, int | None] | None:
    """Return (item type, length) of a tuple's type hint, or None if the hint is not a tuple.

    The length is None where any is allowed. The item type is that of the first item.
    """
    if typing.get_origin(hint) is not tuple:
        return None
    parts = typing.get_args(hint)
    return (parts[0], None) if parts[-1] is Ellipsis else (parts[0], len(parts))


def is_admitted(value: Any, hint: Any, metadata: Mapping[str, Any]) -> bool:
    """Return whether `value` has the type `hint` and is within an option's bounds and choices.

    metadata: of the field, as `option` makes it. An integer counts as a float, a boolean never as a number.
    """
    choices = choices_of(hint)
    if choices and isinstance(value, str):
        return value in choices
    return any(_is_one(value, part, metadata) for part in alternatives(hint))


def _is_one(value: Any, hint: Any, metadata: Mapping[str, Any]) -> bool:
    items = items_of(hint)
    if items is not None:
        kind, count = items
        is_row = isinstance(value, (tuple, list)) or getattr(value, "ndim", 0) == 1
        return (
            is_row
            and count in (None, len(value))
            and all(is_admitted(item, kind, metadata) for item in value)
        )
    if hint in (float, int):
        if isinstance(value, bool) or not isinstance(value, Real if hint is float else Integral):
            return False
        limits = metadata.get("bounds", {}).items()
        return _is_finite(value) and all(BOUNDS[name].holds(value, limit) for name, limit in limits)
    if hint is bool:
        return isinstance(value, (bool, np.bool_))
    if value is None:
        return hint is types.NoneType
    return isinstance(value, hint)


def _is_finite(value: Any) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer too large for a float
        return False


def expectation(hint: Any, metadata: Mapping[str, Any]) -> str:
    """Return a text that describes the values an option allows: "a number > 0 and < 90, in degrees"."""
    if choices := choices_of(hint):
        return "one of " + ", ".join(map(repr, choices))
    kinds = [part for part in alternatives(hint) if part is not types.NoneType]
    unit = metadata.get("unit")
    return " or ".join(_described(kind, metadata) for kind in kinds) + (f", in {unit}" if unit else "")


def _described(hint: Any, metadata: Mapping[str, Any]) -> str:
    items = items_of(hint)
    if items is None:
        name = _NAMES[hint]
        text = f"a {name}" if hint in _WITH_ARTICLE else name
    else:
        kinds = [part for part in alternatives(items[0]) if items_of(part) is None]
        names = " or ".join(f"{_NAMES[kind]}s" if kind in _WITH_ARTICLE else _NAMES[kind] for kind in kinds)
        text = f"a list of {items[1]} {names}" if items[1] else f"a list of {names}"
        hint = items[0]
    limits = metadata.get("bounds", {}).items() if {float, int} & set(alternatives(hint)) else ()
    return text + " and".join(f" {BOUNDS[name].sign} {limit:g}" for name, limit in limits)


def import_user_callable(key: str, name: str, known: Sequence[str]) -> Any:
    """Import and return the user's class or function that `name` gives as package.module:NAME.

    key: the option's name; known: its built-in values, which errors list. Raises CraftmeshError if `name`
    has no colon, if the import raises any exception, or if the object is not callable.
    """
    module, colon, attribute = name.partition(":")
    if not colon:
        near = get_close_matches(name, known, 1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise CraftmeshError(
            f"{key} is {name!r}; expected one of {', '.join(known)}, or your own package.module:NAME{hint}"
        )
    try:
        found = getattr(importlib.import_module(module), attribute)
    except Exception as error:  # the user's module may raise anything
        raise CraftmeshError(
            f"{key} {name!r} cannot be loaded ({type(error).__name__}: {error}); name a class or function "
            "of an installed module"
        ) from error
    if not callable(found):
        raise CraftmeshError(f"{key} {name!r} is {found!r}; expected a class or a function")
    return found


def returned_array(what: str, returned: object, expected: str) -> np.ndarray:
    """Return the result of a user's function as an array of floats of any shape.

    what, expected: the function and the values that it should return, for the error. Raises CraftmeshError
    for values that are no numbers and for rows of different lengths.
    """
    try:
        return np.asarray(returned, float)
    except (TypeError, ValueError):
        raise CraftmeshError(f"{what} returned {returned!r:.60}; expected {expected}") from None
