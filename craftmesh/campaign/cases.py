"""The cases of a campaign: valid names, the type `Case`, and checks of its cracks and microstructure."""

import os
import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from craftmesh.deck.options import DeckOptions
from craftmesh.errors import CraftmeshError, existing, listed, named
from craftmesh.solve.options import BUILTIN

# Names in the results folder that are not cases. Compared in lower case, as macOS and Windows do.
RESERVED = ("logs", "benchmarks", "report.html")
LONGEST = 255  # bytes, the limit of a folder's name on common file systems
_NAME = re.compile(r"\w[\w.-]*")
SYNTHETIC = "synthetic"
NO_CRACK = "none"
PRESCRIBED = "prescribed"


def as_case_name(text: str) -> str:
    """Return `text` with each run of characters that a case name may not have replaced by `_`.

    `_` at either end is removed, so the result may be empty.
    """
    return re.sub(r"[^\w.-]+", "_", unicodedata.normalize("NFC", text)).strip("_")


def check_case_name(name: str, place: str) -> None:
    """Raise CraftmeshError, beginning with `place`, unless `name` is a valid case name."""
    if not _NAME.fullmatch(name):
        raise CraftmeshError(
            f"{place}: invalid case name {name!r}; use letters, digits, _, . and -, but not . or - first"
        )
    if len(name.encode()) > LONGEST:
        raise CraftmeshError(f"{place}: case name has {len(name.encode())} bytes; use at most {LONGEST}")
    if name.casefold() in RESERVED:
        raise CraftmeshError(f"{place}: case name {name!r} is reserved in the results; choose another name")


def check_capitals(names: Iterable[str], place: str) -> None:
    """Raise CraftmeshError, beginning with `place`, if two of `names` differ only in capitals."""
    known: dict[str, str] = {}
    for name in names:
        other = known.setdefault(name.casefold(), name)
        if other != name:
            raise CraftmeshError(f"{place}: cases {other!r} and {name!r} differ only in case; rename one")


@dataclass(frozen=True)
class Case:
    """A case of a campaign. microstructure: a path or SYNTHETIC.

    crack: names of cracks separated by commas, or NO_CRACK.
    growth: PRESCRIBED; "grow" or "until", which mean the same, for growth until the crack ends, after
    `increments` increments at the latest.
    row: the case name in the table's row; it differs from `name` only if a list of values in the row makes
    several cases.
    place: the file, line and case, with which error messages begin.
    swept: the case's value of each column or key (section.key) that has a list of values.
    settings: the campaign's configuration with the case's own values in it.
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
        """The names of the case's cracks; empty for NO_CRACK."""
        return () if self.crack == NO_CRACK else tuple(name.strip() for name in self.crack.split(","))

    @property
    def grows(self) -> bool:
        return self.growth != PRESCRIBED

    @property
    def renews(self) -> bool:
        """True if increments from 001 on keep elements of the increment before."""
        return bool(self.settings["renew"]["reuse"] != "never")

    @property
    def runs_history(self) -> bool:
        """True if an external solver computes load steps instead of one linear elastic field."""
        by_program = self.settings["solve"]["solver"] != BUILTIN
        return by_program and bool(DeckOptions(**self.settings["inp"]).history)

    @property
    def increment_names(self) -> tuple[str, ...]:
        """Folder names of the increments: 000, 001, ..."""
        return tuple(f"{k:03d}" for k in range(self.increments))


def check_case(case: Case) -> None:
    """Raise CraftmeshError if the case's cracks, increments or microstructure are wrong.

    Each crack must be configured and named once, a case without a crack must have one increment and no
    growth, and the microstructure must exist.
    """
    config, place = case.settings, case.place
    known = (*config["cracks"], NO_CRACK)
    for name in case.cracks:
        if name not in config["cracks"]:
            raise CraftmeshError(
                f"{place}: unknown crack {name!r}; known (key `cracks`): {listed(known)}; name one, or "
                "several separated by commas"
            )
    if len(set(case.cracks)) < len(case.cracks):
        raise CraftmeshError(f"{place}: crack {case.crack!r} repeats a name; name each crack once")
    if case.crack == NO_CRACK and case.increments != 1:
        raise CraftmeshError(f"{place}: increments is {case.increments} without a crack; set it to 1")
    if case.crack == NO_CRACK and case.grows:
        raise CraftmeshError(f"{place}: growth is {case.growth} without a crack; set it to {PRESCRIBED}")
    path = case.microstructure
    if path != SYNTHETIC and not os.path.exists(path):
        raise CraftmeshError(
            f"{place}: microstructure {path} does not exist; give a file, or a path in the folder `data`"
        )
    check_exists(f"{place}: microstructure", path if path != SYNTHETIC else None)


def check_exists(key: str, path: str | None) -> None:
    """Raise CraftmeshError, beginning with `key`, if `path` is given but does not exist or is not readable.

    Files and folders are both accepted.
    """
    if path and not os.path.exists(path):
        raise CraftmeshError(f"{key}: {path} does not exist; check the path")
    if path:
        with named(key):
            existing(path)
