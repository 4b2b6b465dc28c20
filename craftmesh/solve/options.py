"""How the field is found."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option

BUILTIN, CALCULIX, ABAQUS, EXTERNAL = "builtin", "calculix", "abaqus", "external"
FIELD = "field.csv"  # of other programs' displacements, beside the solution


@dataclass(frozen=True)
class SolveOptions(Options):
    """Which solver finds the field, how exact it is, and what it may take."""

    solver: str = option(
        BUILTIN,
        "builtin; calculix or abaqus, programs run on the deck; external, a file that is waited for",
        choices=(BUILTIN, CALCULIX, ABAQUS, EXTERNAL),
    )
    tolerance: float = option(
        1e-8, "builtin's largest residual: forces out of balance over reactions and loads", above=0, below=1
    )
    max_iterations: int = option(
        500, "builtin: a field that is not exact enough by then is refused", at_least=1
    )
    integration: str = option(
        "deck",
        "builtin: points at which C3D10 are integrated: deck, the 4 of Abaqus and CalculiX; full, 14, with "
        "which quarter points carry uniform strain exactly too",
        choices=("deck", "full"),
    )
    contact: bool = option(
        True, "builtin: where lips of the crack would overlap they press on each other, without friction"
    )
    command: tuple[str, ...] = option(
        (), "in place of the calls of calculix or abaqus, each a text with {job}, {script} and {field}"
    )
    time_limit: float = option(86400.0, "longest time for each call of a program", "s", above=0)
    memory_limit: float = option(
        16.0,
        "largest memory that builtin may take, as estimated, or a program's address space",
        "GB",
        above=0,
    )

    def __post_init__(self) -> None:
        """Raise CraftmeshError for values out of bounds, and for calls that are none."""
        super().__post_init__()
        for call in self.command:
            words_of(call, "job", "script", "field")

    def check_takes(self, cohesive: bool, steps: bool, plates: bool) -> None:
        """Raise CraftmeshError where a program's field is not read of a deck with what is true of it.

        cohesive: layers on grain boundaries; steps: a history of the load; plates: rigid ones.
        """
        if self.solver == BUILTIN:
            return
        reason = "and there are cohesive layers, with which none of its fields is read" if cohesive else ""
        if steps and self.solver != CALCULIX:
            reason = (
                "whose fields are read where they are linear elastic, and the load comes in steps (steps, "
                "user_material, lip_contact)"
            )
        elif steps and plates:
            reason = "which has no rigid plates to take the load through steps"
        if reason:
            raise CraftmeshError(
                f"solver is {self.solver}, {reason}; expected {BUILTIN}, which takes the welded body, its "
                "load at once, or run the deck of `craftmesh inp` in Abaqus"
            )


def waited_for(field: Path, cases: Sequence[str]) -> list[Path]:
    """Return the files that `external` reads: `field`, or one for each load case by its name."""
    return [field.with_stem(f"{field.stem}_{case}") for case in cases] or [field]


def words_of(call: str, job: str, script: str, field: str) -> list[str]:
    """Return the words of a call of a program, {job}, {script} and {field} filled in."""
    try:
        words = [word.format(job=job, script=script, field=field) for word in shlex.split(call)]
    except (KeyError, IndexError, ValueError) as error:
        raise CraftmeshError(
            f"command {call!r}: {error} is not known; expected {{job}}, {{script}} and {{field}} alone"
        ) from None
    if not words:
        raise CraftmeshError(f"command {call!r} is empty; expected a program and its arguments")
    return words
