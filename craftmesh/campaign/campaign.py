"""A campaign: the checked configuration and cases sheet that the Snakemake workflow runs.

All is checked before any job starts. Functions are pure but for reading the sheet and looking whether
files exist; the Snakefile only calls them.
"""

import json
import shlex
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from craftmesh.campaign.cases import (
    NO_CRACK,
    SYNTHETIC,
    UNTIL,
    Case,
    check_case,
    check_exists,
    located,
    read_cases,
)
from craftmesh.campaign.configuration import completed, load_schema
from craftmesh.campaign.digest import digest
from craftmesh.cracks.options import CrackOptions, crack_files
from craftmesh.deck.includes import mesh_file
from craftmesh.errors import CraftmeshError
from craftmesh.growth.options import GrowthOptions, SmoothingOptions
from craftmesh.io.mesh_formats import MESH_FORMATS
from craftmesh.mechanics.model import ModelOptions

SCHEMAS = Path(__file__).with_name("schemas")
SIZE_FILES = ("points", "field")
CRACK_LENGTHS = ("l_min", "l0")
GrowthReport = Callable[[str, str], str]


@dataclass(frozen=True)
class Campaign:
    """A checked configuration with its cases by name."""

    config: Mapping[str, Any]
    cases: Mapping[str, Case]

    @property
    def results(self) -> str:
        return self.config["results"]

    @property
    def chunks(self) -> int:
        return self.config["chunks"]

    def increments(self, pattern: str, growth: GrowthReport, growing: bool = False) -> list[str]:
        """Return `pattern` with {case} and {inc} filled in for every increment of every case.

        growth: returns the report of the growth after an increment. It is asked for cases that grow until
        they stop, whose increments are not known before. growing: leave the other cases out.
        """
        return [
            pattern.format(case=case.name, inc=inc)
            for case in self.cases.values()
            if case.grows or not growing
            for inc in _reached(case, growth)
        ]

    def growth_reports(self, pattern: str, growth: GrowthReport) -> list[str]:
        """Return `pattern` filled in for every increment after which a crack grows, or would but stops.

        growth: as for `increments`. Nothing follows the last increment that the sheet asks for.
        """
        return [
            pattern.format(case=case.name, inc=inc)
            for case in self.cases.values()
            if case.grows
            for inc in _reached(case, growth)
            if inc != case.increment_names[-1]
        ]

    def microstructure(self, case: str) -> str:
        """Return the file that `craftmesh import` reads."""
        path = self.cases[case].microstructure
        return f"{self.results}/{case}/generated.npz" if path == SYNTHETIC else path

    def crack(self, case: str, inc: str) -> dict[str, str]:
        """Return the crack of an increment as the input `crack`; nothing for a case without a crack."""
        has_crack = self.cases[case].crack != NO_CRACK
        return {"crack": f"{self.results}/{case}/{inc}/crack.vtp"} if has_crack else {}

    def previous_crack(self, case: str, inc: str) -> dict[str, str]:
        """Return the crack of the increment before as the input `previous`; nothing for the first."""
        return {"previous": self.crack(case, f"{int(inc) - 1:03d}")["crack"]} if int(inc) else {}

    def crack_options(self, case: str, inc: str) -> list[dict[str, Any]]:
        """Return the keys of each crack of an increment; those that have grown are surfaces in one file."""
        if self.cases[case].grows and int(inc):
            grown = f"{self.results}/{case}/{int(inc) - 1:03d}/grown.vtp"
            return [{"shape": "surface", "file": grown}]
        return [self.config["cracks"][name] for name in self.cases[case].cracks]

    def crack_files(self, case: str, inc: str) -> list[str]:
        """Return the files that describe the cracks of an increment; none for prescribed shapes."""
        named = [crack_files(CrackOptions(**keys), int(inc)) for keys in self.crack_options(case, inc)]
        return [path for files in named for path in files.values()]

    def size_files(self) -> list[str]:
        """Return the files that the sizing function reads."""
        return [self.config["sizing"][key] for key in SIZE_FILES if self.config["sizing"][key]]

    def deck_files(self, model: str) -> list[str]:
        """Return the files of the deck `model`: itself, and its mesh where the deck includes it."""
        return [model, str(mesh_file(model))] if self.config["inp"]["includes"] else [model]

    def exports(self, model: str) -> list[str]:
        """Return the files in which the mesh of the deck `model` is written as well."""
        return [str(Path(model).with_suffix(f".{kind}")) for kind in self.config["exports"]]

    @property
    def export_kinds(self) -> str:
        """The formats of an export, as the pattern of a wildcard."""
        return "|".join(MESH_FORMATS)

    def flags(self, section: str) -> str:
        """Return the command-line flags of one section of the configuration."""
        return command_flags(self.config[section])

    def deck_flags(self, case: str) -> str:
        """Return the flags of a case's deck."""
        return command_flags(self._deck(case))

    def mesh_flags(self, case: str) -> str:
        """Return the flags of `inp` that an export takes too, so that its mesh is the deck's."""
        deck = self._deck(case)
        return command_flags({key: deck[key] for key in ("element", "quarter_points")})

    def model_flags(self, case: str) -> str:
        """Return the flags of `inp` that make the deck's model, which is solved and integrated."""
        deck = self._deck(case)
        return command_flags({field.name: deck[field.name] for field in fields(ModelOptions)})

    def growth_flags(self) -> str:
        """Return the flags of the kink angles and extensions that `craftmesh fracture` finds."""
        return self._flags_of("grow", GrowthOptions)

    def smoothing_flags(self) -> str:
        """Return the flags of `craftmesh grow`, which moves the fronts by them."""
        return self._flags_of("grow", SmoothingOptions)

    def _flags_of(self, section: str, cls: type) -> str:
        return command_flags({field.name: self.config[section][field.name] for field in fields(cls)})

    def until_flag(self, case: str) -> str:
        """Return the flag of `craftmesh grow` for a crack that may stop."""
        return "--until" if self.cases[case].growth == UNTIL else ""

    def _deck(self, case: str) -> dict[str, Any]:
        """Return the keys of a case's deck: the elements of a crack that grows have quarter points."""
        deck = dict(self.config["inp"])
        if deck["quarter_points"] is None:
            deck["quarter_points"] = self.cases[case].grows
        return deck

    def import_flags(self, case: str) -> str:
        """Return the flags of `craftmesh import`; a synthetic volume is clean and needs none."""
        return "" if self.cases[case].microstructure == SYNTHETIC else self.flags("import")

    def crack_flags(self, case: str, inc: str) -> str:
        """Return the flags of an increment's cracks, and of the lengths that they are held against."""
        lengths = {key: self.config["sizing"][key] for key in CRACK_LENGTHS}
        first, *others = map(command_flags, self.crack_options(case, inc))
        return " --and ".join([" ".join([command_flags(lengths), first]).strip(), *others])

    def code(self, verb: str) -> str:
        """Return the digest of the modules that a verb of the command line runs."""
        return digest(f"craftmesh.commands.{verb}")


def _reached(case: Case, growth: GrowthReport) -> Iterator[str]:
    """Yield the names of the increments that a case has: all, or those before its crack stops."""
    for inc in case.increment_names:
        yield inc
        last = inc == case.increment_names[-1]
        if case.growth == UNTIL and not last and _has_ended(growth(case.name, inc)):
            return


def _has_ended(report: str) -> bool:
    return bool(json.loads(Path(report).read_text(encoding="utf-8"))["ended"])


def read_campaign(config: Mapping[str, Any]) -> Campaign:
    """Check `config` against the schemas, its sheet and its files, and fill in the defaults.

    Raises CraftmeshError with one line that names the key, case or file, the value found and what is
    expected.
    """
    config = completed(config, load_schema(SCHEMAS / "config.schema.yaml"))
    check_sizes(config["sizing"])
    for key in SIZE_FILES:
        check_exists(f"sizing.{key}", config["sizing"][key])
    cases = read_cases(Path(config["cases"]), load_schema(SCHEMAS / "cases.schema.yaml"))
    for case in cases.values():
        check_case(case, config)
        if case.grows and config["inp"]["element"] != "C3D10":
            raise CraftmeshError(
                f"inp.element is {config['inp']['element']}, and the crack of case {case.name!r} grows; "
                "expected C3D10, whose displacements give its stress intensities"
            )
    data = Path(config["data"])
    cases = {
        name: replace(case, microstructure=located(case.microstructure, data))
        for name, case in cases.items()
    }
    return Campaign(config, cases)


def check_sizes(sizing: Mapping[str, Any]) -> None:
    """Raise CraftmeshError unless the numbers of Eq. 3, defaults included, fit each other.

    Without l0, which the microstructure gives later, there are no defaults to hold the others against.
    """
    import numpy as np

    from craftmesh.sizing.sizing import SizingOptions, sizing_for

    try:
        options = SizingOptions(**sizing)
        if options.l0 is not None:
            sizing_for(None, options, np.zeros((0, 3)))
    except CraftmeshError as error:
        raise CraftmeshError(f"sizing: {error}") from None


def command_flags(options: Mapping[str, Any]) -> str:
    """Return options as the command line takes them: lists as several values, lists in lists as a,b.

    Keys whose value is null or empty are left out.
    """
    words: list[str] = []
    for key, value in options.items():
        flag = key.replace("_", "-")
        if isinstance(value, bool):
            words.append(f"--{flag}" if value else f"--no-{flag}")
        elif value is not None and value != [] and value != "":
            values = value if isinstance(value, (list, tuple)) else [value]
            words += [
                f"--{flag}",
                *(",".join(map(str, v)) if isinstance(v, list) else str(v) for v in values),
            ]
    return shlex.join(words)
