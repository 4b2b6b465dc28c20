"""A campaign: the checked configuration and case table that the Snakemake workflow runs.

Everything is checked before any job starts; the Snakefile only calls these functions. They read files,
but write none apart from the digests and phases that `file_digest` and `phases` keep for the next run.
"""

import os
import re
import shlex
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from craftmesh.campaign.cases import NO_CRACK, SYNTHETIC, Case, check_case
from craftmesh.campaign.configuration import completed, fields_of, load_schema
from craftmesh.campaign.digest import digest
from craftmesh.campaign.option_checks import check_meaning, small_cracks
from craftmesh.campaign.paths import files_of, read_path, with_paths, written_path
from craftmesh.campaign.phases import phase_notes
from craftmesh.campaign.sheet import Rules, read_cases
from craftmesh.cracks.options import OF_GRAINS, CrackOptions, crack_files
from craftmesh.deck.includes import mesh_file
from craftmesh.deck.options import OF_THE_FILE
from craftmesh.errors import named
from craftmesh.growth.options import CorrectionOptions, GrowthOptions, SmoothingOptions
from craftmesh.insertion.options import InsertOptions
from craftmesh.io.json_file import read_json
from craftmesh.io.mesh_formats import EXPORTS, GRAIN_TABLE
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.voxels.options import CleanOptions

SCHEMAS = Path(__file__).with_name("schemas")
CRACK_LENGTHS = ("l_min", "l0")
GrowthReport = Callable[[str, str], str]


@dataclass(frozen=True)
class Campaign:
    """A checked configuration and its cases, by case name."""

    config: Mapping[str, Any]
    cases: Mapping[str, Case]

    @property
    def results(self) -> str:
        return self.config["results"]

    @property
    def chunks(self) -> int:
        return self.config["chunks"]

    @property
    def notes(self) -> list[str]:
        """Warnings of one line each: cracks of few elements, phases without material, unused materials."""
        cases = self.cases.values()
        return [*small_cracks(cases), *phase_notes(cases)]

    def increments(self, growing: bool = False, others: Collection[str] = ()) -> list[tuple[str, str]]:
        """Return the case and the increment of every increment that the case table requests.

        growing: omit cases that do not grow, except those named in `others`.
        """
        return [
            (case.name, inc)
            for case in self.cases.values()
            if case.grows or not growing or case.name in others
            for inc in case.increment_names
        ]

    def growths(self) -> list[tuple[str, str]]:
        """Return the case and the increment of all increments after which a crack is to grow."""
        asked = self.increments(growing=True)
        return [(case, inc) for case, inc in asked if int(inc) + 1 < self.cases[case].increments]

    def is_reached(self, case: str, inc: str, growth: GrowthReport) -> bool:
        """Return True unless the growth after an earlier increment ended the crack.

        growth: returns, for case and increment, the path of the report of the growth after it. Reports that
        do not exist yet do not count.
        """
        if not self.cases[case].grows:
            return True
        reports = (Path(growth(case, before)) for before in self.cases[case].increment_names[: int(inc)])
        return not any(_is_end((path, path.stat().st_mtime_ns)) for path in reports if path.exists())

    def generated(self, case: str) -> list[str]:
        """Return the file of a synthetic volume, which `craftmesh import` reads; [] for other cases."""
        is_synthetic = self.cases[case].microstructure == SYNTHETIC
        return [f"{self.results}/{case}/generated.npz"] if is_synthetic else []

    def crack(self, case: str, inc: str) -> dict[str, str]:
        """Return {"crack": file} of an increment; {} for a case without a crack."""
        has_crack = self.cases[case].crack != NO_CRACK
        return {"crack": f"{self.results}/{case}/{inc}/crack.vtp"} if has_crack else {}

    def solution(self, case: str, inc: str) -> dict[str, str]:
        """Return {"solution": file} of an increment if its case grows or runs a history; else {}."""
        is_shown = self.cases[case].grows or self.cases[case].runs_history
        return {"solution": f"{self.results}/{case}/{inc}/solution.npz"} if is_shown else {}

    def previous_crack(self, case: str, inc: str) -> dict[str, str]:
        """Return {"previous": file}, the previous increment's crack, and `grown`, its crack after growth.

        {} for increment 000; `grown` only for a case that grows.
        """
        before = f"{self.results}/{case}/{int(inc) - 1:03d}"
        grown = {"grown": f"{before}/grown.vtp"} if self.cases[case].grows else {}
        return {"previous": f"{before}/crack.vtp", **grown} if int(inc) else {}

    @property
    def renewed(self) -> str:
        """The cases whose meshes are renewed, as a regular expression for a Snakemake wildcard.

        Without such cases the expression matches nothing.
        """
        names = [case.name for case in self.cases.values() if case.renews]
        return "|".join(map(re.escape, names)) or "(?!)"

    def mesh_before(self, case: str, inc: str) -> dict[str, str]:
        """Return {"before": mesh, "sizing_before": sizing} of the previous increment.

        From increment 002 on also {"map_before": file}, because the previous mesh was renewed too.
        """
        before = f"{self.results}/{case}/{int(inc) - 1:03d}"
        numbers = {"map_before": f"{before}/map.npz"} if int(inc) > 1 else {}
        return {"before": f"{before}/volume.vtu", "sizing_before": f"{before}/sizing.npz", **numbers}

    def renew_flags(self, case: str) -> str:
        """Return the flags of `craftmesh renew`: its own and the flags of the stages that it calls."""
        settings = self.cases[case].settings
        stitch = fields_of(InsertOptions, settings["stitch"])
        return command_flags(settings["renew"] | stitch | settings["gradate"] | settings["tetrahedralize"])

    def last_step(self, case: str, inc: str) -> dict[str, str]:
        """Return the files `base` and `step` that growth wrote in the previous increment; {} for 000."""
        before = f"{self.results}/{case}/{int(inc) - 1:03d}"
        return {"base": f"{before}/base.vtp", "step": f"{before}/step.csv"} if int(inc) else {}

    def last_front(self, case: str, inc: str) -> dict[str, str]:
        """Return the files `last` and `last_growth` of the increment from which the crack grew; else {}.

        They are its reports of K and of growth.
        """
        before = f"{self.results}/{case}/{int(inc) - 1:03d}"
        found = {"last": f"{before}/fracture.json", "last_growth": f"{before}/growth.json"}
        return found if self.cases[case].grows and int(inc) else {}

    def crack_options(self, case: str, inc: str) -> list[dict[str, Any]]:
        """Return the options of each crack of an increment.

        All cracks of an increment after growth are one, a surface from the file that growth wrote.
        """
        if self.cases[case].grows and int(inc):
            return [{"shape": "surface", "file": self.previous_crack(case, inc)["grown"]}]
        return [self.cases[case].settings["cracks"][name] for name in self.cases[case].cracks]

    def crack_surface(self, case: str, inc: str) -> dict[str, str]:
        """Return {"surface": file} of the grains if a crack's shape is made from them; else {}."""
        is_of_grains = any(keys.get("shape") in OF_GRAINS for keys in self.crack_options(case, inc))
        return {"surface": f"{self.results}/{case}/remeshed.vtp"} if is_of_grains else {}

    def crack_files(self, case: str, inc: str) -> list[str]:
        """Return the files that describe the cracks of an increment; prescribed shapes have none."""
        named = [crack_files(CrackOptions(**keys), int(inc)) for keys in self.crack_options(case, inc)]
        return [path for files in named for path in files.values()]

    def section_files(self, section: str, case: str) -> list[str]:
        """Return the files that a section of a case's configuration names."""
        return list(files_of(section, self.cases[case].settings[section]).values())

    def deck_files(self, model: str) -> list[str]:
        """Return the files of the input deck `model`: the deck, and its mesh file if it includes one."""
        return [model, str(mesh_file(model))] if self.config["inp"]["includes"] else [model]

    def exports(self, model: str) -> list[str]:
        """Return the files to which the deck's mesh is exported; .msh adds a table of the grains."""
        kinds = dict.fromkeys(kind.removeprefix(".") for kind in self.config["exports"])
        kinds |= {GRAIN_TABLE: None} if "msh" in kinds else {}
        return [str(Path(model).with_suffix(f".{kind}")) for kind in kinds]

    @property
    def export_kinds(self) -> str:
        """The export formats as a regular expression for a Snakemake wildcard."""
        return "|".join(EXPORTS)

    def flags(self, section: str, case: str) -> str:
        """Return the command-line flags of one section of a case's configuration."""
        return command_flags(self.cases[case].settings[section])

    def deck_flags(self, case: str) -> str:
        """Return the flags of `craftmesh inp`, which writes a case's input deck."""
        return f"{command_flags(self._deck(case))} {self.unit_flags(case)}".rstrip()

    def unit_flags(self, case: str) -> str:
        """Return the flag --units of a case; empty if the case names no unit."""
        units = list(self.cases[case].settings["units"].values())
        return command_flags({"units": units}) if any(units) else ""

    def export_flags(self, case: str) -> str:
        """Return the flags of `craftmesh export`, with the deck's element type and quarter points."""
        deck = self._deck(case)
        flags = {key: deck[key] for key in ("element", "quarter_points")}
        return command_flags(flags | self.cases[case].settings["export"])

    def model_flags(self, case: str) -> str:
        """Return the `inp` flags of the model: elements, materials and loads, as solved and integrated."""
        return command_flags(fields_of(ModelOptions, self._deck(case)))

    def solved_flags(self, case: str) -> str:
        """Return the `inp` flags that a case's solver needs; a history adds the flags of its steps."""
        if not self.cases[case].runs_history:
            return self.model_flags(case)
        deck = self._deck(case)
        return command_flags({key: deck[key] for key in deck if key not in OF_THE_FILE})

    def growth_flags(self, case: str) -> str:
        """Return the flags of `craftmesh fracture` for kink angles and front extensions."""
        return command_flags(fields_of(GrowthOptions, self.cases[case].settings["grow"]))

    def grow_flags(self, case: str) -> str:
        """Return the flags of `craftmesh grow`, which moves the fronts by these extensions."""
        keys = self.cases[case].settings["grow"]
        return command_flags(fields_of(SmoothingOptions, keys) | fields_of(CorrectionOptions, keys))

    def _deck(self, case: str) -> dict[str, Any]:
        """Return the values of a case's section `inp`.

        If quarter_points is null, it is set to whether the crack grows.
        """
        deck = dict(self.cases[case].settings["inp"])
        if deck["quarter_points"] is None:
            deck["quarter_points"] = self.cases[case].grows
        return deck

    def import_flags(self, case: str) -> str:
        """Return the flags of `craftmesh import`; for a synthetic volume only the cleaning flags."""
        if self.cases[case].microstructure == SYNTHETIC:
            return command_flags(fields_of(CleanOptions, self.cases[case].settings["import"]))
        return self.flags("import", case)

    def crack_flags(self, case: str, inc: str) -> str:
        """Return the options of `craftmesh crack` for an increment as text.

        First come l_min and l0, then the options of each crack, separated by --and.
        """
        sizing = self.cases[case].settings["sizing"]
        held = {key: sizing[key] for key in CRACK_LENGTHS}
        first, *others = map(command_flags, self.crack_options(case, inc))
        return " --and ".join([" ".join([command_flags(held), first]).strip(), *others])

    def code(self, verb: str) -> str:
        """Return the digest of the modules that a subcommand of the command line runs."""
        return digest(f"craftmesh.commands.{verb}")


@cache
def _is_end(version: tuple[Path, int]) -> bool:
    """Return True if a report of growth has a reason why the crack ended.

    version: path and modification time of the report, the key of the cache, because Snakemake asks for each
    report many times.
    """
    return bool(read_json(version[0])["ended"])


def read_campaign(config: Mapping[str, Any]) -> Campaign:
    """Check `config` and its case table, fill in the defaults, and return the campaign.

    Raises CraftmeshError with one line that names the key, case or file, the value found and what is
    expected, for values that schemas or stages reject, and for missing files.
    """
    schema = load_schema(SCHEMAS / "config.schema.yaml")
    config = with_paths(completed(config, schema))
    config |= {key: read_path(key, config[key]) for key in ("cases", "data")}
    config["results"] = written_path("results", config["results"])
    rules = Rules(load_schema(SCHEMAS / "cases.schema.yaml"), schema, config)
    cases = {
        name: _with_paths(case, config) for name, case in read_cases(Path(config["cases"]), rules).items()
    }
    for case in cases.values():
        check_case(case)
        check_meaning(case, config)
    return Campaign(config, cases)


def _with_paths(case: Case, config: Mapping[str, Any]) -> Case:
    """Return a case with its paths expanded and checked; errors begin with the case's place."""
    written_path(f"{case.place}: its folder", f"{config['results']}/{case.name}")
    path = case.microstructure
    if path != SYNTHETIC:
        path = read_path(f"{case.place}: microstructure", path, Path(config["data"]))
        # the word `synthetic` alone is a generated volume, ./synthetic a file of this name
        path = os.path.abspath(path) if path == SYNTHETIC else path
    with named(case.place):
        return replace(case, microstructure=path, settings=with_paths(case.settings))


def command_flags(options: Mapping[str, Any]) -> str:
    """Return options as command-line flags, quoted for a shell.

    A list becomes several values, and a list in a list a value such as a,b. A boolean becomes --key or
    --no-key. Keys with a null or empty value are left out.
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
