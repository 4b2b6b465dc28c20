"""Status of the cases in a results folder, found from its files and logs, whichever machine runs them."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from craftmesh.campaign.cases import PRESCRIBED, SYNTHETIC
from craftmesh.campaign.job_resources import RULES as KNOWN
from craftmesh.campaign.job_resources import Sizes, effort, expected_elements, sizes_of
from craftmesh.errors import CraftmeshError
from craftmesh.io.json_file import read_json
from craftmesh.io.npz import read_labels
from craftmesh.io.stage_npz import read_sizing
from craftmesh.report.case_files import (
    ERROR,
    RECORD,
    STAGES,
    Failure,
    job_costs,
    last_line,
    log_errors,
)
from craftmesh.sizing.stored import sizing_of

# Stages whose content volume.vtu also has; their files may be missing once volume.vtu exists.
SPARE_STAGES = ("surface", "gradated", "tets")
SPARE = tuple(STAGES[name].made for name in SPARE_STAGES)
RULES = {"import": "import_microstructure"}  # names of the workflow's rules that differ from the stage's
PRIOR = 2.0  # seconds of measured jobs that have the same weight as the plan's estimate
_PROGRESS = re.compile(r"\w+ +(\d+)% ")  # a line of `ProgressLine` in a log


class Job(NamedTuple):
    """A stage of an increment, or of the whole case if `increment` is empty; name: a key of STAGES."""

    increment: str
    name: str

    @property
    def stage(self) -> str:
        return STAGES[self.name].verb


@dataclass(frozen=True)
class Standing:
    """Status of a case.

    at_most: whether the crack grows and may end before its last increment. job: the job that runs or is
    next, None if all is made; runs: whether it has begun. share: fraction of the work that is done; left:
    expected seconds of the remaining jobs one after the other; both count all increments. left is None
    before the first increment's target lengths are known. ended: why the crack stopped before its last
    increment, else "". failures: errors at the ends of logs. doubted: increments with a front on which no K
    is reliable.
    """

    case: str
    increments: int
    at_most: bool
    job: Job | None
    runs: bool
    share: float
    left: float | None
    ended: str
    failures: list[Failure]
    doubted: list[str]

    def __str__(self) -> str:
        """Return the status as one line of text for the user."""
        if self.failures:
            log, line = self.failures[0].log, self.failures[0].line
            return f"{self.case}: failed, {log}: {line}"
        doubts = f"; no reliable K in {', '.join(self.doubted)}, see report.html" * bool(self.doubted)
        if self.job is None:
            return f"{self.case}: " + (f"stopped, {self.ended}" if self.ended else "all is made") + doubts
        words = [self.job.stage if self.runs else f"{self.job.stage} waits"]
        if self.job.increment:
            of = f"{'at most ' * self.at_most}{self.increments}"
            words.insert(0, f"increment {self.job.increment} ({int(self.job.increment) + 1} of {of})")
        words.append(f"{100 * self.share:.0f} %")
        if self.left is not None:
            words.append(f"{self.left:.0f} s left" if self.left < 100 else f"{self.left / 60:.0f} min left")
        return f"{self.case}: {', '.join(words)}{doubts}"


def case_statuses(results: Path, campaign: str | None = None, since: float = 0.0) -> list[Standing]:
    """Return the status of each case that has begun in the folder `results`.

    campaign: path of a case table, for only the cases of this campaign; since: time in seconds since the
    epoch; older logs are ignored.
    """
    records = {path.parent.name: read_json(path) for path in sorted(results.glob(f"*/{RECORD}"))}
    paces = _paces(results, records)
    return [
        _standing(results, name, record, since, paces)
        for name, record in records.items()
        if campaign in (None, record["campaign"])
    ]


def _standing(
    results: Path, case: str, record: Mapping[str, Any], since: float, paces: Mapping[str, float]
) -> Standing:
    """Return the status of a case.

    record: the content of its file RECORD; since: older logs are ignored; paces: measured over expected
    seconds by stage, "" for other stages.
    """
    folder = results / case
    ended = _end(folder, record)
    steps = list(_steps(results, case, record, ended[0] if ended else record["increments"], since))
    current = next(((job, begun) for job, share, begun in steps if share < 1), None)
    voxels = _sizes(folder, "")
    # Work by the sizes of the voxels only, which do not change, so that the fraction done only grows.
    works = [_expected(job.stage, voxels) for job, *_ in steps]
    done = sum(work * share for work, (_, share, _) in zip(works, steps))
    sizes = {job.increment: _sizes(folder, job.increment) for job, *_ in steps}
    left = sum(
        (1 - share) * _expected(job.stage, sizes[job.increment]) * paces.get(job.stage, paces[""])
        for job, share, _ in steps
    )
    is_sized = (folder / "000" / STAGES["sizing"].made).is_file()
    return Standing(
        case=case,
        increments=record["increments"],
        at_most=record["growth"] != PRESCRIBED,
        job=current and current[0],
        runs=current is not None and current[1],
        share=done / sum(works),
        left=left if is_sized else None,
        ended=ended[1] if ended else "",
        failures=log_errors(results, case, since) if current else [],
        doubted=[job.increment for job, share, _ in steps if share == 1 and _is_doubted(folder, job)],
    )


def _paces(results: Path, cases: Iterable[str]) -> dict[str, float]:
    """Return the ratio of measured to expected seconds of finished jobs by stage, "" for all stages.

    A stage's longest job is left out if there are others, because it may have compiled kernels. The ratio
    of all stages includes PRIOR seconds of jobs with ratio 1, so it is near 1 while few jobs are measured.
    """
    took: dict[str, list[tuple[float, float]]] = {}
    for case in cases:
        for increment, stage, part, row in job_costs(results / "benchmarks" / case):
            if RULES.get(stage, stage) in KNOWN:
                expected = part * _expected(stage, _sizes(results / case, increment))
                took.setdefault(stage, []).append((row["s"], expected))
    kept = {stage: sorted(jobs)[: max(len(jobs) - 1, 1)] for stage, jobs in took.items()}
    sums = {stage: np.sum(jobs, axis=0) for stage, jobs in kept.items()}
    measured, expected = sum(sums.values(), np.full(2, PRIOR))
    return {stage: own[0] / own[1] for stage, own in sums.items()} | {"": measured / expected}


def _sizes(folder: Path, increment: str) -> Sizes:
    """Return the sizes of an increment, or with "" those by the labels only.

    The elements follow from the latest mesh, gradated surface or target lengths up to this increment.
    """
    labels = folder / STAGES["microstructure"].made
    sizes = sizes_of(labels)
    for number in range(int(increment), -1, -1) if increment else ():
        made = (folder / f"{number:03d}" / STAGES[name].made for name in ("volume", "gradated", "sizing"))
        for path in filter(Path.is_file, made):
            if path.suffix != ".npz":
                return replace(sizes, elements=sizes_of(path).elements)
            return replace(sizes, elements=_elements(labels, path, _time(path)))
    return sizes


@cache
def _elements(labels: Path, sizing: Path, _: float) -> float:
    """Return the number of elements expected for the target lengths in a sizing.npz.

    The result is kept in memory for this file and the modification time `_`.
    """
    try:
        return expected_elements(read_labels(labels), sizing_of(read_sizing(sizing)))
    except CraftmeshError:  # the stage that reads the file reports the error
        return sizes_of(labels).elements


def _is_doubted(folder: Path, job: Job) -> bool:
    """Return True if a finished job is `fracture` and found a front on which no K is reliable."""
    path = folder / job.increment / STAGES["fracture"].made
    return job.name == "fracture" and bool(read_json(path).get("growth", {}).get("doubted"))


def _expected(stage: str, sizes: Sizes) -> float:
    """Return the expected CPU seconds of a stage's work on an increment, without compiling its kernels."""
    return effort(RULES.get(stage, stage), sizes, chunks=1).seconds


def _steps(
    results: Path, case: str, record: Mapping[str, Any], increments: int, since: float
) -> Iterator[tuple[Job, float, bool]]:
    """Yield each job, the fraction of it that is done, and whether it has a log, so that it has begun.

    Jobs that need an unfinished job count as not done, because their files are from an earlier run. In a
    case that grows these are all later jobs, else the later jobs of the increment.
    """
    grows = record["growth"] != PRESCRIBED
    is_made = {"": True}  # by increment, or only by "" if increments depend on each other
    for job in jobs(record, increments):
        way = "" if grows else job.increment
        logs = results / "logs" / case / job.increment
        parts = [*logs.glob(f"{job.name}.log"), *logs.glob(f"{job.name}/*.log")]
        log = max((part for part in parts if _time(part) >= since), key=_time, default=None)
        reached = is_made.setdefault(way, is_made[""])
        share = _share_made(results / case / job.increment / STAGES[job.name].made, log) if reached else 0.0
        is_made[way] = share == 1
        yield job, share, log is not None


def jobs(record: Mapping[str, Any], increments: int) -> Iterator[Job]:
    """Yield the jobs of a case, as its `record` requests, in the order in which they run."""
    if record["microstructure"] == SYNTHETIC:
        yield Job("", "generated")
    yield from (Job("", name) for name in ("microstructure", "remeshed"))
    grows = record["growth"] != PRESCRIBED
    left_out = set() if record["cracks"] else {"crack"}
    left_out |= set() if grows else {"solution", "fracture", "growth"}
    names = [name for name in list(STAGES)[3:] if name not in left_out]
    renews = record.get("config", {}).get("renew", {}).get("reuse", "never") != "never"
    for number in range(increments):
        last = grows and number == increments - 1
        others = ["growth"] * last + ([*SPARE_STAGES, "volume"] if renews and number else ["renewed"])
        yield from (Job(f"{number:03d}", name) for name in names if name not in others)


def _end(folder: Path, record: Mapping[str, Any]) -> tuple[int, str] | None:
    """Return the number of increments and the reason, if the crack stopped early; else None."""
    for number in range(record["increments"] if record["growth"] != PRESCRIBED else 0):
        path = folder / f"{number:03d}" / STAGES["growth"].made
        if not path.is_file():
            break
        reason = read_json(path)["ended"]
        if reason:
            return number + 1, reason
    return None


def _is_done(log: Path, volume: Path) -> bool:
    """Return True if a log is not newer than the mesh, or if its last line is that of a finished job.

    The line counts too, because copied files have other times.
    """
    line = last_line(log)
    has_ended = line and not line.startswith(ERROR) and not _PROGRESS.match(line)
    return _time(log) <= _time(volume) or bool(has_ended)


def _time(path: Path) -> float:
    return path.stat().st_mtime


def _share_made(path: Path, log: Path | None) -> float:
    """Return the fraction of a job that is done.

    It is 1 if the job's file `path` exists, or if only volume.vtu needs this file and exists. Otherwise it
    is the percentage in the last line of its log, or 0. Jobs of tetrahedra count the parts that are made.
    """
    volume = path.with_name(STAGES["volume"].made)
    if path.name in SPARE and volume.is_file() and (log is None or _is_done(log, volume)):
        return 1.0
    if path.name == "tets" and log is not None:  # folder with one file K-of-N.npz per part
        parts = int(log.stem.rpartition("-")[2])
        made = len(list(path.glob(f"*-of-{parts}.npz")))
        return min(made / parts, 1.0)
    if path.exists():
        return 1.0
    found = _PROGRESS.match(last_line(log)) if log else None
    return int(found[1]) / 100 if found and int(found[1]) < 100 else 0.0
