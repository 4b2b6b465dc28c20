"""Arrays beside grain ids: what their names say, which table belongs to which ids, what is left unread."""

import os
import re
from collections.abc import Collection, Iterable, Mapping

from craftmesh.errors import CraftmeshError, listed
from craftmesh.io.file_volume import DEGREES, RADIANS

_EULERS = re.compile(r"euler", re.I)
_QUATERNIONS = re.compile(r"quat", re.I)
_ORIENTATIONS = re.compile(r"euler|bunge|quat|rodrig|orient|rotation|axis_?angle|^phi_?[12]$", re.I)
_PHASES = re.compile(r"(cell|feature|grain|parent)?_?phases?(_?ids?)?", re.I)
_IDS = re.compile(r"(cell|feature|grain|parent|region|twin|material)_?ids?|material|labels?", re.I)
_UNITS = {
    DEGREES: re.compile(r"deg(?![a-z])|degree|°", re.I),
    RADIANS: re.compile(r"\brad\b|Rad\b|radian", re.I),
}


def is_eulers(name: str) -> bool:
    """Return whether an array's name says that it holds Euler angles."""
    return bool(_EULERS.search(name))


def is_quaternions(name: str) -> bool:
    """Return whether an array's name says that it holds quaternions."""
    return bool(_QUATERNIONS.search(name))


def is_phases(name: str) -> bool:
    """Return whether an array's name says that it holds phases."""
    return bool(_PHASES.fullmatch(name))


def is_ids(name: str) -> bool:
    """Return whether an array's name says that it holds ids of grains."""
    return bool(_IDS.fullmatch(name))


def is_described(name: str) -> bool:
    """Return whether an array's name says that it holds orientations, phases or ids of grains."""
    return bool(_ORIENTATIONS.search(name)) or is_phases(name) or is_ids(name)


def unit_said(*texts: str) -> str:
    """Return DEGREES or RADIANS where a file's words name one of them, else ""."""
    named = [unit for unit, pattern in _UNITS.items() if any(pattern.search(text) for text in texts)]
    return named[0] if len(named) == 1 else ""


def belonging(
    path: str | os.PathLike, rows: Mapping[str, int], largest: int, claimed: Collection[int] = ()
) -> str:
    """Return the table that belongs to ids up to `largest`, row = id, or "" where none does.

    rows: table -> how many it has. It is the one with a row for each id and none over; else one with more
    rows, as of a part cut out of a volume, but not one that fits other ids: claimed, their counts of rows.
    Raises CraftmeshError where several fit alike.
    """
    wanted = largest + 1
    fitting = [name for name, count in rows.items() if count == wanted]
    fitting = fitting or [name for name, count in rows.items() if count > wanted and count not in claimed]
    if len(fitting) > 1:
        raise CraftmeshError(
            f"{path}: ids reach {largest}, and several tables fit them: {listed(fitting)}; "
            "give table as one of them or its group"
        )
    return fitting[0] if fitting else ""


def left_unread(names: Iterable[str]) -> tuple[str, ...]:
    """Return the note on arrays of a file that were not read; none without names."""
    names = list(names)
    return (f"left unread: {listed(names)}",) if names else ()
