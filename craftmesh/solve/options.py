"""Options of the solver."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option

BUILTIN, CALCULIX, ABAQUS, EXTERNAL = "builtin", "calculix", "abaqus", "external"
FIELD = "field.csv"  # file of displacements from another program, next to the solution


@dataclass(frozen=True)
class SolveOptions(Options):
    """The solver, its tolerance, and its limits of time and memory."""

    solver: Literal["builtin", "calculix", "abaqus", "external"] = option(
        BUILTIN,
        "builtin; calculix or abaqus, run on the deck; external, a file that craftmesh waits for",
    )
    tolerance: float = option(
        1e-8, "builtin: largest residual, forces out of balance over reactions and loads", above=0, below=1
    )
    max_iterations: int = option(
        500, "builtin: largest number; a field that is then not exact enough is rejected", at_least=1
    )
    integration: Literal["deck", "full"] = option(
        "deck",
        "builtin: integration points of C3D10: deck, the 4 of Abaqus and CalculiX; full, 14, for which "
        "quarter-point elements reproduce uniform strain exactly",
    )
    contact: bool = option(True, "builtin: lips of the crack that would overlap press on each other")
    command: tuple[str, ...] = option(
        (), "commands to run instead of calculix or abaqus, with {job}, {script} and {field}"
    )
    time_limit: float = option(86400.0, "longest time for each call of a program", "s", above=0)
    memory_limit: float = option(
        16.0,
        "largest estimated memory of builtin, or address space of another program",
        "GB",
        above=0,
    )

    def __post_init__(self) -> None:
        """Raise CraftmeshError for values out of bounds and for invalid commands."""
        super().__post_init__()
        for call in self.command:
            split_command(call, "job", "script", "field")

    def check_takes(self, cohesive: bool, steps: bool, plates: bool) -> None:
        """Raise CraftmeshError if the field of the solver on a deck could not be read.

        cohesive: the deck has cohesive layers; steps: its load is a history; plates: it has rigid plates.
        The built-in solver, which reads no deck, always passes.
        """
        if self.solver == BUILTIN:
            return
        reason = "but its fields are not read from decks with cohesive layers" if cohesive else ""
        if steps and self.solver != CALCULIX:
            reason = (
                "but its fields are read only if linear elastic, and the load comes in steps (steps, "
                "user_material, lip_contact)"
            )
        elif steps and plates:
            reason = "but it has no rigid plates for a load in steps"
        if reason:
            raise CraftmeshError(
                f"solver is {self.solver}, {reason}; use {BUILTIN}, which solves the welded body with its "
                "load at once, or run the deck of `craftmesh inp` in Abaqus"
            )


def waited_for(field: Path, cases: Sequence[str]) -> list[Path]:
    """Return the files that solver external reads: `field`, or one per load case, FIELD_CASE.csv."""
    return [field.with_stem(f"{field.stem}_{case}") for case in cases] or [field]


def split_command(call: str, job: str, script: str, field: str) -> list[str]:
    """Split the command line `call` into words and substitute {job}, {script} and {field}.

    Raises CraftmeshError for other placeholders, open quotes, and an empty line.
    """
    try:
        words = [word.format(job=job, script=script, field=field) for word in shlex.split(call)]
    except (KeyError, IndexError, ValueError) as error:
        raise CraftmeshError(
            f"command {call!r} is invalid ({error}); use only {{job}}, {{script}} and {{field}} in braces"
        ) from None
    if not words:
        raise CraftmeshError(f"command {call!r} is empty; expected a program and its arguments")
    return words
