"""The sheet of cases: its rows, and that what they name is there."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from craftmesh.campaign.configuration import completed, listed
from craftmesh.cracks.options import CrackOptions, crack_files
from craftmesh.errors import CraftmeshError

SYNTHETIC = "synthetic"
NO_CRACK = "none"
COLUMNS = ("case", "microstructure", "crack", "increments")
OPTIONAL = ("growth",)  # columns that a sheet may have after those
PRESCRIBED, GROW, UNTIL = "prescribed", "grow", "until"
RESERVED = ("logs", "benchmarks")


@dataclass(frozen=True)
class Case:
    """One row of the sheet: its name, the microstructure's path or SYNTHETIC, its cracks or NO_CRACK.

    crack: names with commas between them.
    growth: PRESCRIBED, GROW, or UNTIL the crack stops, after `increments` at the latest.
    """

    name: str
    microstructure: str
    crack: str
    increments: int
    growth: str = PRESCRIBED

    @property
    def cracks(self) -> tuple[str, ...]:
        """The names of its cracks, none where it has none."""
        return () if self.crack == NO_CRACK else tuple(name.strip() for name in self.crack.split(","))

    @property
    def grows(self) -> bool:
        return self.growth != PRESCRIBED

    @property
    def increment_names(self) -> tuple[str, ...]:
        """The increments' folder names: 000, 001, ..."""
        return tuple(f"{k:03d}" for k in range(self.increments))


def read_cases(path: Path, schema: dict) -> dict[str, Case]:
    """Read the tab-separated sheet of cases; lines that start with # are left out.

    Raises CraftmeshError that names the file, and the line and the case where they matter.
    """
    if not path.is_file():
        raise CraftmeshError(
            f"cases: {path} is not there; expected a tab-separated sheet with {listed(COLUMNS)}"
        )
    lines = path.read_text(encoding="utf-8-sig").splitlines()
    numbered = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    rows = list(csv.reader((line for _, line in numbered), delimiter="\t"))
    columns = tuple(name.strip() for name in rows[0]) if rows else ()
    if columns not in (COLUMNS, COLUMNS + OPTIONAL):
        raise CraftmeshError(
            f"{path}: columns {listed(columns) or 'nothing'}; expected {listed(COLUMNS)} and perhaps "
            f"{listed(OPTIONAL)}, separated by tabs"
        )
    cases: dict[str, Case] = {}
    for (number, _), row in zip(numbered[1:], rows[1:]):
        case = _case(columns, row, schema, f"{path}, line {number}")
        if case.name in cases:
            raise CraftmeshError(
                f"{path}, line {number}: case {case.name!r} is there twice; names must differ"
            )
        cases[case.name] = case
    if not cases:
        raise CraftmeshError(f"{path}: no case; expected at least one row under the header")
    return cases


def _case(columns: tuple[str, ...], row: list[str], schema: dict, place: str) -> Case:
    values: dict[str, Any] = dict(zip(columns, (field.strip() for field in row)))
    if len(row) != len(columns):
        raise CraftmeshError(f"{place}, case {row[0]!r}: {len(row)} columns; expected {len(columns)}")
    if values["increments"].isdecimal():
        values["increments"] = int(values["increments"])
    try:
        values = completed(values, schema)
    except CraftmeshError as error:
        raise CraftmeshError(f"{place}, case {row[0]!r}: {error}") from None
    if values["case"] in RESERVED:
        raise CraftmeshError(
            f"{place}: case {values['case']!r} is a folder of the results; choose another name"
        )
    values["name"] = values.pop("case")
    return Case(**values)


def check_case(case: Case, config: Mapping[str, Any]) -> None:
    """Raise CraftmeshError unless the case's crack, its increments and all its files are there."""
    place = f"{config['cases']}, case {case.name!r}"
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
    for name in case.cracks:
        _check_series(case, name, config)
    path = Path(located(case.microstructure, Path(config["data"])))
    if case.microstructure != SYNTHETIC and not path.exists():
        raise CraftmeshError(
            f"{place}: microstructure {path} is not there; expected a file, or a path under the key `data`"
        )


def _check_series(case: Case, crack: str, config: Mapping[str, Any]) -> None:
    """Raise where a crack of the case lacks an increment, or a file of one."""
    key, options = f"cracks.{crack}", CrackOptions(**config["cracks"][crack])
    series, prescribed = options.increments, 1 if case.grows else case.increments
    if series and len(series) < prescribed:
        raise CraftmeshError(
            f"{key}.increments prescribes {len(series)} increments; "
            f"case {case.name!r} of {config['cases']} asks for {prescribed}"
        )
    for increment in range(prescribed):
        for name, path in crack_files(options, increment).items():
            check_exists(f"{key}.{name}", path)


def check_exists(key: str, path: str | None) -> None:
    """Raise CraftmeshError, naming the key, where a path is given and nothing is there."""
    if path and not Path(path).exists():
        raise CraftmeshError(f"{key}: {path} is not there; expected a file")


def located(microstructure: str, data: Path) -> str:
    """Return the path of a microstructure that the sheet names, or SYNTHETIC."""
    return microstructure if microstructure == SYNTHETIC else str(data / microstructure)
