"""Fields of the stages' frozen option classes: one definition serves library, CLI and config."""

from dataclasses import MISSING, field
from typing import Any


def option(default: Any, help: str, unit: str = "", choices: tuple = ()) -> Any:
    """Return a dataclass field that carries its own help text, unit and admitted values.

    `default` may be MISSING for a value that the user has to give.
    """
    metadata = {"help": help, "unit": unit, "choices": choices}
    if default is MISSING:
        return field(metadata=metadata)
    return field(default=default, metadata=metadata)
