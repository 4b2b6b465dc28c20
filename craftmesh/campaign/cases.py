"""The cases of a campaign: names, which are folders and words of commands, and what cases name."""

import os
import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from craftmesh.deck.options import DeckOptions
from craftmesh.errors import CraftmeshError, existing, listed, named
from craftmesh.solve.options import BUILTIN

# files of the results' own; macOS and Windows tell no files apart by capitals, and results are moved about
RESERVED = ("logs", "benchmarks", "report.html")
LONGEST = 255  # bytes of a folder's name on common file systems
_NAME = re.compile(r"\w[\w.-]*")
SYNTHETIC = "synthetic"
NO_CRACK = "none"
PRESCRIBED, GROW, UNTIL = "prescribed", "grow", "until"


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


@dataclass(frozen=True)
class Case:
    """A case: its name, the microstructure's path or SYNTHETIC, its cracks or NO_CRACK.

    crack: names with commas between them.
    growth: PRESCRIBED, or GROW until the crack ends, after `increments` at the latest. UNTIL means GROW.
    row: the name of its row of the sheet, which is its own but for sweeps.
    place: the file and line of that row, and the case, for messages.
    swept: its values of the columns and keys (section.key) of which the other cases of its row have others.
    settings: the configuration with the keys that are its own in it.
    """

    name: str
    microstructure: str
    crack: str
    increments: int
    growth: str = PRESCRIBED
    row: str = ""
    place: str = ""
    swept: Mapping[str, Any] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def cracks(self) -> tuple[str, ...]:
        """The names of its cracks, none where it has none."""
        return () if self.crack == NO_CRACK else tuple(name.strip() for name in self.crack.split(","))

    @property
    def grows(self) -> bool:
        return self.growth != PRESCRIBED

    @property
    def runs_history(self) -> bool:
        """Whether a program takes the load through steps, in place of a linear elastic field."""
        by_program = self.settings["solve"]["solver"] != BUILTIN
        return by_program and bool(DeckOptions(**self.settings["inp"]).history)

    @property
    def increment_names(self) -> tuple[str, ...]:
        """The increments' folder names: 000, 001, ..."""
        return tuple(f"{k:03d}" for k in range(self.increments))


def check_case(case: Case) -> None:
    """Raise CraftmeshError unless the case's cracks are known, and its microstructure is there."""
    config, place = case.settings, case.place
    known = (*config["cracks"], NO_CRACK)
    for name in case.cracks:
        if name not in config["cracks"]:
            raise CraftmeshError(
                f"{place}: crack is {name!r}; expected one of {listed(known)} (key `cracks`), or several "
                "with commas between them"
            )
    if len(set(case.cracks)) < len(case.cracks):
        raise CraftmeshError(f"{place}: crack is {case.crack!r}; expected each crack once")
    if case.crack == NO_CRACK and case.increments != 1:
        raise CraftmeshError(f"{place}: increments is {case.increments} without a crack; expected 1")
    if case.crack == NO_CRACK and case.grows:
        raise CraftmeshError(f"{place}: growth is {case.growth} without a crack; expected {PRESCRIBED}")
    path = case.microstructure
    if path != SYNTHETIC and not os.path.exists(path):
        raise CraftmeshError(
            f"{place}: microstructure {path} is not there; expected a file, or a path under the key `data`"
        )
    check_exists(f"{place}: microstructure", path if path != SYNTHETIC else None)


def check_exists(key: str, path: str | None) -> None:
    """Raise CraftmeshError, naming the key, where a path is given and no file or folder is there."""
    if path and not os.path.exists(path):
        raise CraftmeshError(f"{key}: {path} is not there; expected a file")
    if path:
        with named(key):
            existing(path)
