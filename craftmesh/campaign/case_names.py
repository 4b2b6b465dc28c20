"""Which names a case may have: they are folders, words of a command line and parts of Snakemake's jobs."""

import re
import unicodedata
from collections.abc import Iterable

from craftmesh.errors import CraftmeshError

# files of the results' own; macOS and Windows tell no files apart by capitals, and results are moved about
RESERVED = ("logs", "benchmarks", "report.html")
LONGEST = 255  # bytes of a folder's name on common file systems
_NAME = re.compile(r"\w[\w.-]*")


def as_case_name(text: str) -> str:
    """Return `text` as part of a case's name: `_` for what may not be in one, empty where nothing may."""
    return re.sub(r"[^\w.-]+", "_", unicodedata.normalize("NFC", text)).strip("_")


def check_case_name(name: str, place: str) -> None:
    """Raise CraftmeshError, beginning with `place`, unless a case may be called `name`."""
    if not _NAME.fullmatch(name):
        raise CraftmeshError(
            f"{place}: case is {name!r}; expected letters, digits, _, . and -, first a letter, a digit or _"
        )
    if len(name.encode()) > LONGEST:
        raise CraftmeshError(f"{place}: case has {len(name.encode())} bytes; expected at most {LONGEST}")
    if name.casefold() in RESERVED:
        raise CraftmeshError(f"{place}: case {name!r} is a name of the results' own; choose another name")


def check_capitals(names: Iterable[str], place: str) -> None:
    """Raise CraftmeshError, beginning with `place`, where two of `names` differ in capitals alone."""
    known: dict[str, str] = {}
    for name in names:
        other = known.setdefault(name.casefold(), name)
        if other != name:
            raise CraftmeshError(f"{place}: cases {other!r} and {name!r} differ in capitals alone; rename")
