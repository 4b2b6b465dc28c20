"""Estimate what a campaign will run before it runs: jobs, elements, time and memory."""

import argparse
import json
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from craftmesh.campaign.campaign import Campaign, read_campaign
from craftmesh.campaign.cases import SYNTHETIC, Case
from craftmesh.campaign.configuration import fields_of
from craftmesh.campaign.job_resources import (
    RULES,
    Effort,
    Sizes,
    effort,
    expected_elements,
    expected_facets,
)
from craftmesh.campaign.workflow_location import Job, or_default, planned_jobs, read_config
from craftmesh.commands.crack import given_surface
from craftmesh.commands.mesh_flags import given_defects, notes_on_sources
from craftmesh.commands.stage_io import add_config, add_report, warn
from craftmesh.cracks.near_faces import refuse_near_faces
from craftmesh.cracks.options import BY_NUMBERS, OF_GRAINS, CrackOptions
from craftmesh.cracks.prescription import is_sized, semi_axes
from craftmesh.cracks.series import crack_of_increment
from craftmesh.cracks.sheets import one_crack, sheets
from craftmesh.cracks.within_box import is_in_material
from craftmesh.errors import CraftmeshError, existing, named
from craftmesh.growth.steps import share_of_size
from craftmesh.io.json_file import write_json
from craftmesh.io.npz import read_labels
from craftmesh.sizing.sizing import Sizing, SizingOptions, voxel_edge
from craftmesh.sizing.sources import Defects, sizing_around
from craftmesh.types import Crack, Voxels
from craftmesh.voxels.clean import clean
from craftmesh.voxels.generate import GenerateOptions, generate
from craftmesh.voxels.options import CleanOptions
from craftmesh.voxels.reading import ReadOptions, read_voxels
from craftmesh.voxels.remapping import as_raw

UNCOUNTED = ("points", "field", "curvature", "around_voids")  # keys of sizing that add elements, uncounted


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_config(parser)
    parser.add_argument(
        "--cores", type=int, default=2, metavar="N", help="cores of the machine (default 2)"
    )
    add_report(parser)


def run(arguments: argparse.Namespace) -> int:
    path = arguments.config
    campaign = read_campaign(or_default(read_config(existing(path)) if path else {}))
    jobs = planned_jobs(["--configfile", str(path)] if path else [])
    report: dict[str, Any] = {"jobs": len(jobs), "by_rule": _by_rule(jobs), "cases": {}}
    jobs_by_case: dict[str, list[Job]] = {}
    for job in jobs:
        jobs_by_case.setdefault(job.case, []).append(job)
    shared = campaign.chunks, campaign.config["warm"]
    efforts = [(job, effort(job.rule, Sizes(0, 0, 0), *shared)) for job in jobs_by_case.get("", [])]
    faults: list[str] = []
    due = [case for name, case in campaign.cases.items() if name in jobs_by_case]
    sizes = sizes_of(campaign, due, faults)
    for name in campaign.cases:
        own, by_increment = jobs_by_case.get(name, []), sizes.get(name, {})
        report["cases"][name] = {"jobs": 0}
        if own:
            first = next(iter(by_increment.values()))
            mine = [(job, effort(job.rule, by_increment.get(job.increment, first), *shared)) for job in own]
            efforts += mine
            elements = {inc: int(one.elements) for inc, one in by_increment.items()}
            report["cases"][name] = _figures(mine) | {"by_rule": _by_rule(own), "elements": elements}
    report |= _figures(efforts)
    report["minutes"] = round(wall_seconds(efforts, campaign, arguments.cores) / 60, 2)
    report["notes"] = [*faults, *notes(campaign)]
    for line in sentences(report, arguments.cores):
        print(line)
    if arguments.report:
        write_json(arguments.report, report)
    return 1 if faults else 0


def sizes_of(
    campaign: Campaign, cases: Collection[Case], faults: list[str] | None = None
) -> dict[str, dict[str, Sizes]]:
    """Return, by case and increment, the expected sizes: numbers of voxels, facets and elements.

    All increments of the case table count. Cases that agree in all settings on which sizes depend are
    computed once. faults: a sentence is appended for each case whose crack the stages will reject.
    """
    sizes: dict[str, dict[str, Sizes]] = {}
    known: dict[str, dict[str, Sizes]] = {}
    fault: dict[str, str] = {}
    for case in cases:
        made = Path(campaign.results) / case.name / "labels.npz"
        keys = case.settings["import"]
        if case.microstructure == SYNTHETIC:
            keys = case.settings["generate"] | {"seed": 0}  # sizes hardly depend on the seed
        volume = [case.microstructure, json.dumps(keys), json.dumps(case.settings["import"])]
        volume = [str(made)] if made.is_file() else volume
        asked = {key: case.settings[key] for key in ("cracks", "sizing", "stitch")}
        key = json.dumps([volume, asked, case.crack, case.increments, case.growth, case.settings["grow"]])
        if key not in known:
            voxels = read_labels(made) if made.is_file() else _filled(*volume)
            facets, known[key], fault[key] = expected_facets(voxels), {}, ""
            for inc in case.increment_names:
                try:
                    cracks = cracks_of_increment(case, voxels, int(inc))
                except CraftmeshError as error:
                    cracks, fault[key] = {}, fault[key] or f"{error}"
                sizing = sizing_of_increment(case, voxels, cracks)
                if not known[key]:
                    warn_of_points(case, voxels, sizing)
                elements = expected_elements(voxels, sizing)
                known[key][inc] = Sizes(voxels.labels.size, facets, elements)
                if not fault[key] and not (case.grows and int(inc)):
                    fault[key] = fault_of(cracks, voxels, sizing.l_min)
        sizes[case.name] = known[key]
        if fault[key] and faults is not None:
            faults.append(f"case {case.name}: {fault[key]}")
    return sizes


@lru_cache(maxsize=1)  # the cases of a sweep follow one another
def _filled(microstructure: str, made: str, imported: str) -> Voxels:
    """Return the volume of a microstructure, cleaned only if it has unindexed voxels.

    made: the section `generate` as JSON, used if the microstructure is synthetic; imported: the section
    `import` as JSON. Other cleaning is omitted, because only filling changes the amount of material.
    """
    keys = json.loads(imported)
    if microstructure == SYNTHETIC:
        volume = as_raw(generate(GenerateOptions(**json.loads(made))))
    else:
        read = ReadOptions(**fields_of(ReadOptions, keys))
        volume = read_voxels(microstructure, read, fills=keys["fill_unindexed"])
    if not volume.unindexed.any():
        return volume.voxels
    return clean(volume, CleanOptions(**fields_of(CleanOptions, keys)))[0]


def cracks_of_increment(case: Case, voxels: Voxels, increment: int) -> dict[str, Crack]:
    """Return estimates of an increment's cracks by name, before anything is solved.

    A growing crack of a shape by numbers is enlarged by one step per increment. A growing crack from files
    keeps its initial size. A crack in grains (along boundaries or on a slip plane) counts as a penny of its
    radius, and is left out if it has no radius or centre. Prints warnings. Raises CraftmeshError that names
    the crack if it is outside the box or if its file cannot be read.
    """
    cracks = {}
    for name in case.cracks:
        crack_options = CrackOptions(**case.settings["cracks"][name])
        if crack_options.shape in OF_GRAINS:
            if not is_sized(crack_options) or crack_options.centre is None:
                continue
            radius, _ = semi_axes(crack_options, increment)
            crack_options = CrackOptions(centre=crack_options.centre, radius=radius)
        which = 0 if case.grows else increment
        if case.grows and crack_options.shape in BY_NUMBERS:
            share = case.settings["grow"]["share"] or share_of_size(case.settings["grow"]["change"])
            crack_options = _grown(crack_options, (1 + share) ** increment)
        with named(f"crack {name} will be refused"):
            surface, report = given_surface(crack_options, which, voxels.box, voxels)
            cracks[name] = crack_of_increment(crack_options, which, voxels.box, surface)
        place = f"{case.name}, increment {increment}, crack {name}"
        warn(*(f"{place}: {note}" for note in report.get("notes", ())))
    return cracks


def fault_of(cracks: Mapping[str, Crack], voxels: Voxels, l_min: float) -> str:
    """Return the reason why stages will reject a crack (no material, or close to a face), else "".

    cracks: by name.
    """
    for name, crack in cracks.items():
        if not is_in_material(crack, voxels):
            return (
                f"crack {name} lies in no material and will be refused; move it, or check import.background"
            )
        try:
            for sheet in sheets(crack):
                refuse_near_faces(sheet, voxels.box, l_min, lines_too=False)
        except CraftmeshError as error:
            return f"crack {name} will be refused: {error}"
    return ""


def warn_of_points(case: Case, voxels: Voxels, sizing: Sizing) -> None:
    """Print a warning if some refinement points of a case are outside the box.

    Raises CraftmeshError if all points are too far outside to have an effect.
    """
    options = SizingOptions(points=case.settings["sizing"]["points"])
    given = given_defects(options, voxels.box)
    points = {Path(options.points): given.centres} if options.points else {}
    warn(*(f"{case.name}: {note}" for note in notes_on_sources(points, given, sizing, voxels.box)))


def sizing_of_increment(case: Case, voxels: Voxels, cracks: Mapping[str, Crack]) -> Sizing:
    """Return the sizing of a case around the fronts of its cracks.

    The keys `field` and `curvature` are ignored. cracks: of the increment, by name.
    """
    options = SizingOptions(**{**case.settings["sizing"], "field": None, "curvature": None})
    if options.l0 is None:
        options = replace(options, l0=voxel_edge(voxels))
    given = given_defects(options, voxels.box)
    # with options.around_voids: centres of the enclosed voids' voxels next to grains
    beside = (voxels.labels < 0) & scipy.ndimage.binary_dilation(voxels.labels > 0) & options.around_voids
    points = [given.points, voxels.origin + (np.argwhere(beside) + 0.5) * voxels.spacing]
    crack = one_crack(list(cracks.values())) if cracks else None
    return sizing_around(None, Defects(crack, np.concatenate(points), given.spheres), options)


def _grown(options: CrackOptions, factor: float) -> CrackOptions:
    if options.semi_axes is not None:
        a, b = options.semi_axes
        return replace(options, semi_axes=(factor * a, factor * b))
    return replace(options, radius=None if options.radius is None else factor * options.radius)


def _by_rule(jobs: list[Job]) -> dict[str, int]:
    counts = Counter(job.rule for job in jobs)
    return {rule: counts[rule] for rule in RULES if rule in counts}


def _figures(efforts: list[tuple[Job, Effort]]) -> dict[str, Any]:
    return {
        "jobs": len(efforts),
        "cpu_minutes": round(sum(one.seconds for _, one in efforts) / 60, 2),
        "largest_job_gb": round(max((one.megabytes for _, one in efforts), default=0.0) / 1000, 2),
    }


def sentences(report: dict[str, Any], cores: int) -> Iterator[str]:
    """Yield the lines that a plan prints."""
    if not report["jobs"]:
        yield "nothing to run: all files are up to date"
        return
    yield f"{report['jobs']} jobs: " + ", ".join(f"{n} {rule}" for rule, n in report["by_rule"].items())
    for name, case in report["cases"].items():
        if not case["jobs"]:
            yield f"case {name}: nothing to run"
            continue
        sizes = sorted(case["elements"].values())
        span = f"{sizes[0]:,.0f}" if len(sizes) == 1 else f"{sizes[0]:,.0f} to {sizes[-1]:,.0f}"
        yield (
            f"case {name}: {case['jobs']} jobs, {len(sizes)} increment{'s' * (len(sizes) > 1)} "
            f"of about {span} elements, "
            f"{case['cpu_minutes']:.1f} min of CPU, largest job {case['largest_job_gb']:.1f} GB"
        )
    yield (
        f"all: about {report['cpu_minutes']:.1f} min of CPU, {report['minutes']:.1f} min on {cores} cores, "
        f"largest job {report['largest_job_gb']:.1f} GB"
    )
    for note in report["notes"]:
        yield f"note: {note}"


def wall_seconds(efforts: list[tuple[Job, Effort]], campaign: Campaign, cores: int) -> float:
    """Return the expected wall-clock seconds of the jobs on `cores` cores.

    It is the larger of the total time per core and the time of the longest case. Chunks of an increment's
    tetrahedra run in parallel; increments of a case whose crack grows or whose meshes are renewed run one
    by one, increments of other cases in parallel.
    """
    shared = sum(one.seconds for _, one in efforts) / cores
    chains = [0.0]
    for case in campaign.cases.values():
        own: dict[str, float] = {}
        for job, one in efforts:
            if job.case == case.name:
                side = min(cores, campaign.chunks) if job.rule == "tetrahedralize" else 1
                own[job.increment] = own.get(job.increment, 0.0) + one.seconds / side
        first = own.pop("", 0.0)
        in_turn = case.grows or case.renews
        chains.append(first + (sum(own.values()) if in_turn else max(own.values(), default=0.0)))
    return max(shared, *chains)


def notes(campaign: Campaign) -> Iterator[str]:
    """Yield sentences on what the estimates leave out, and the campaign's notes and units."""
    yield "times are without the compilation of kernels, some two and a half minutes once per machine"
    yield from campaign.notes
    units = [f"{name} {unit}" for name, unit in campaign.config["units"].items() if unit]
    if units:
        yield f"units, as labels: {', '.join(units)}"
    for case in campaign.cases.values():
        if case.renews and case.increments > 1:
            yield (
                f"case {case.name}: increments from 001 on are counted with 15 % of the elements renewed; "
                "an increment made from scratch takes about four times as long"
            )
        left_out = [key for key in UNCOUNTED if case.settings["sizing"][key]]
        if left_out:
            yield f"case {case.name}: elements for sizing.{', sizing.'.join(left_out)} are not counted"
        if any(case.settings["cracks"][name]["shape"] in OF_GRAINS for name in case.cracks):
            yield f"case {case.name}: its crack in grains is counted as a penny of its radius"
