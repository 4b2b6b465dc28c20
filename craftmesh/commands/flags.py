"""Command-line flags made from the stages' option classes, and back."""

import argparse
import dataclasses
import re
import types
from collections.abc import Callable, Iterable
from typing import Any, NoReturn

from craftmesh.errors import CraftmeshError
from craftmesh.options import alternatives, choices_of, hints_of, items_of


class Parser(argparse.ArgumentParser):
    """An argument parser that raises CraftmeshError instead of printing its usage and exiting."""

    def __init__(self, **keywords: Any):
        super().__init__(allow_abbrev=False, **keywords)
        # argparse takes -1e-3 for a flag unless its pattern of negative numbers knows exponents
        self._negative_number_matcher = re.compile(r"^-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")

    def error(self, message: str) -> NoReturn:
        raise CraftmeshError(f"{message}; see `{self.prog} --help`")


def add_options(parser: argparse.ArgumentParser, *classes: type, skip: Iterable[str] = ()) -> None:
    """Add one group of flags for each option class, a flag per field.

    skip: names of fields that get no flag.
    """
    for cls in classes:
        words = re.findall("[A-Z][a-z]+", cls.__name__.removesuffix("Options"))
        group = parser.add_argument_group(" ".join(words).lower() + " options")
        for field in dataclasses.fields(cls):
            if field.name not in skip:
                _add_flag(group, field, hints_of(cls)[field.name])


def options_from(arguments: argparse.Namespace, cls: type, **values: Any) -> Any:
    """Return an instance of the option class `cls` from the parsed flags; `values` override flags.

    Options whose flags are not given have their defaults. Raises CraftmeshError for invalid values.
    """
    given = {
        field.name: getattr(arguments, field.name)
        for field in dataclasses.fields(cls)
        if hasattr(arguments, field.name)
    }
    lists = {name: tuple(value) for name, value in given.items() if isinstance(value, list)}
    return cls(**(given | lists | values))


def _add_flag(group: argparse._ArgumentGroup, field: dataclasses.Field, hint: Any) -> None:
    """Add the flag of one field; a flag that is not given leaves no attribute in the parsed arguments."""
    flag = "--" + field.name.replace("_", "-")
    required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
    keywords: dict[str, Any] = {"default": argparse.SUPPRESS, "required": required, "help": _help(field)}
    kind, count = value_type(hint)
    choices = choices_of(hint) or None
    if kind is bool:
        group.add_argument(flag, action=argparse.BooleanOptionalAction, **keywords)
    else:
        name = field.name.upper() if choices is None else None
        group.add_argument(flag, type=kind, nargs=count, choices=choices, metavar=name, **keywords)


def value_type(hint: Any) -> tuple[Callable, int | str | None]:
    """Return the type of a field's values, and the `nargs` of argparse: None, "+" or a number.

    A field that may be a number, numbers or text has the type `word`.
    """
    kind, *others = (part for part in alternatives(hint) if part is not types.NoneType)
    items = items_of(kind)
    if items is None:
        return (word if others else kind), None
    return value_type(items[0])[0], items[1] or "+"


def word(text: str) -> float | str | tuple:
    """Return a text as a number, as a tuple of numbers if they are joined by commas, else unchanged."""
    try:
        numbers = tuple(map(float, text.split(",")))
    except ValueError:
        return text
    return numbers if "," in text else numbers[0]


def _help(field: dataclasses.Field) -> str:
    text = field.metadata.get("help", "")
    unit = field.metadata.get("unit")
    default = field.default
    if isinstance(default, tuple):
        default = " ".join(map(str, default))
    notes = [f"in {unit}"] if unit else []
    if default not in (None, "", dataclasses.MISSING):
        notes.append(f"default {default}")
    return (text + (f" ({'; '.join(notes)})" if notes else "")).replace("%", "%%")
