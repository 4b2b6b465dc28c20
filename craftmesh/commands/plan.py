"""Tell what a campaign will run before it runs: jobs, elements, about how long and how much memory."""

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from craftmesh.campaign.campaign import Campaign, read_campaign
from craftmesh.campaign.cases import UNTIL
from craftmesh.campaign.dry_run import Job, planned_jobs
from craftmesh.campaign.effort import RULES, Effort, Sizes, effort
from craftmesh.campaign.home import or_default, read_config
from craftmesh.commands.expected_sizes import sizes_of
from craftmesh.commands.stage_io import add_report, existing, write_json
from craftmesh.cracks.options import IN_BOUNDARIES

UNCOUNTED = ("points", "field", "curvature", "around_voids")  # keys of sizing that add elements


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "config",
        type=Path,
        nargs="?",
        help="configuration .yaml; left out: the one that snakemake would take",
    )
    parser.add_argument(
        "--cores", type=int, default=2, metavar="N", help="cores of the machine (default 2)"
    )
    add_report(parser)


def run(arguments: argparse.Namespace) -> None:
    path = arguments.config
    campaign = read_campaign(or_default(read_config(existing(path)) if path else {}))
    jobs = planned_jobs(["--configfile", str(path)] if path else [])
    report: dict[str, Any] = {"jobs": len(jobs), "by_rule": _by_rule(jobs), "cases": {}}
    jobs_by_case: dict[str, list[Job]] = {}
    for job in jobs:
        jobs_by_case.setdefault(job.case, []).append(job)
    efforts = [(job, effort(job.rule, Sizes(0, 0, 0))) for job in jobs_by_case.get("", [])]
    sizes = sizes_of(campaign, [case for name, case in campaign.cases.items() if name in jobs_by_case])
    for name in campaign.cases:
        own, by_increment = jobs_by_case.get(name, []), sizes.get(name, {})
        report["cases"][name] = {"jobs": 0}
        if own:
            first = next(iter(by_increment.values()))
            mine = [
                (job, effort(job.rule, by_increment.get(job.increment, first), campaign.chunks))
                for job in own
            ]
            efforts += mine
            elements = {inc: int(one.elements) for inc, one in by_increment.items()}
            report["cases"][name] = _figures(mine) | {"by_rule": _by_rule(own), "elements": elements}
    report |= _figures(efforts)
    report["minutes"] = round(wall_seconds(efforts, campaign, arguments.cores) / 60, 2)
    report["notes"] = list(notes(campaign))
    for line in sentences(report, arguments.cores):
        print(line)
    if arguments.report:
        write_json(arguments.report, report)


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
    """Yield what a plan tells, one line each."""
    if not report["jobs"]:
        yield "nothing to run: all is there"
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
    """Return the time that the jobs take on `cores` cores: shared out, but those of a growing case in turn.

    The chunks of an increment's tetrahedra run side by side; the increments of a case that grows do not.
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
        chains.append(first + (sum(own.values()) if case.grows else max(own.values(), default=0.0)))
    return max(shared, *chains)


def notes(campaign: Campaign) -> Iterator[str]:
    """Yield what the figures leave out."""
    yield "times are without the compilation of kernels, some four minutes once per machine"
    yield from campaign.notes
    units = [f"{name} {unit}" for name, unit in campaign.config["units"].items() if unit]
    if units:
        yield f"units, as labels: {', '.join(units)}"
    for case in campaign.cases.values():
        if case.growth == UNTIL:
            yield f"case {case.name}: jobs after the first increment are planned as the crack grows"
        left_out = [key for key in UNCOUNTED if case.settings["sizing"][key]]
        if left_out:
            yield f"case {case.name}: elements for sizing.{', sizing.'.join(left_out)} are not counted"
        if any(case.settings["cracks"][name]["shape"] == IN_BOUNDARIES for name in case.cracks):
            yield f"case {case.name}: its crack along grain boundaries is counted as a penny of its radius"
