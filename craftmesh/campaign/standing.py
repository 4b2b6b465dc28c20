"""Status of the cases in a results folder, found from its files and logs, whichever machine runs them."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median_low
from typing import Any, NamedTuple

from craftmesh.campaign.cases import PRESCRIBED, SYNTHETIC
from craftmesh.campaign.effort import Sizes, effort, sizes_of
from craftmesh.io.json_file import read_json
from craftmesh.report.case_files import RECORD, STAGES, Failure, last_line, log_errors, stage_costs

# Files whose content volume.vtu also has; they may be missing once it exists.
SPARE = tuple(STAGES[name].made for name in ("surface", "gradated", "tets"))
RULES = {"import": "import_microstructure"}  # names of the workflow's rules that differ from the stage's
_PROGRESS = re.compile(r"\w+ +(\d+)% ")  # a line of `ProgressLine` in a log


class Job(NamedTuple):
    """A stage of an increment, or of the whole case if `increment` is empty; name: of its log file."""

    increment: str
    name: str

    @property
    def stage(self) -> str:
        return STAGES[self.name].verb


@dataclass(frozen=True)
class Standing:
    """Status of a case.

    at_most: whether the crack grows and may end before its last increment. job: the job that runs or is
    next, None if all is made; runs: whether it has begun. share: fraction of the work that is done, and
    left: seconds of the remaining jobs in sequence; both count all increments. left is None before the
    microstructure is imported. ended: why the crack stopped before its last increment, else empty.
    failures: errors at the ends of logs. doubted: increments with a front on which no K is reliable.
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


def standings(results: Path, campaign: str | None = None, since: float = 0.0) -> list[Standing]:
    """Return the status of each case that has begun in the folder `results`, of one `campaign` if given.

    since: time in seconds since the epoch; older logs are ignored.
    """
    records = {path.parent.name: read_json(path) for path in sorted(results.glob(f"*/{RECORD}"))}
    return [
        standing(results, name, record, since)
        for name, record in records.items()
        if campaign in (None, record["campaign"])
    ]


def standing(results: Path, case: str, record: Mapping[str, Any], since: float = 0.0) -> Standing:
    """Return the status of a case; record: its content of the file RECORD; since: as for `standings`."""
    folder = results / case
    ended = _end(folder, record)
    steps = list(_steps(results, case, record, ended[0] if ended else record["increments"], since))
    current = next(((job, begun) for job, share, begun in steps if share < 1), None)
    sizes = sizes_of(folder / "labels.npz")
    works = [_expected(job.stage, sizes, 1) for job, _, _ in steps]
    done = sum(work * share for work, (_, share, _) in zip(works, steps))
    took = stage_costs(results / "benchmarks" / case, [f"{k:03d}" for k in range(record["increments"])])
    # Measured paces leave out each stage's longest job, because it may have compiled kernels.
    paces = [(c.seconds - c.longest) / (c.jobs - 1) / _expected(c.stage, sizes) for c in took if c.jobs > 1]
    timed = (folder / STAGES["microstructure"].made).is_file()
    return Standing(
        case=case,
        increments=record["increments"],
        at_most=record["growth"] != PRESCRIBED,
        job=current and current[0],
        runs=current is not None and current[1],
        share=done / sum(works),
        left=median_low([1.0, *paces]) * (sum(works) - done) if timed else None,
        ended=ended[1] if ended else "",
        failures=log_errors(results, case, since) if current else [],
        doubted=[job.increment for job, share, _ in steps if share == 1 and _is_doubted(folder, job)],
    )


def _is_doubted(folder: Path, job: Job) -> bool:
    """Return True if a finished job `fracture` found a front on which no K is reliable."""
    path = folder / job.increment / STAGES["fracture"].made
    return job.name == "fracture" and bool(read_json(path).get("growth", {}).get("doubted"))


def _expected(stage: str, sizes: Sizes, chunks: int = 2) -> float:
    """Return the estimated seconds of a job of a stage, without compiling its kernels."""
    return effort(RULES.get(stage, stage), sizes, chunks).seconds


def _steps(
    results: Path, case: str, record: Mapping[str, Any], increments: int, since: float
) -> Iterator[tuple[Job, float, bool]]:
    """Yield each job, the fraction of it that is done, and whether it has begun.

    Jobs after an unfinished job count as not done, because their files are from an earlier run.
    """
    grows = record["growth"] != PRESCRIBED
    is_made = {"": True}  # by increment, if increments do not depend on each other
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
    for number in range(increments):
        last = grows and number == increments - 1
        yield from (Job(f"{number:03d}", name) for name in names if not (last and name == "growth"))


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


def _time(path: Path) -> float:
    return path.stat().st_mtime


def _share_made(path: Path, log: Path | None) -> float:
    """Return the fraction of a job that is done: 1 if its file `path` exists, else that in its log."""
    volume = path.with_name(STAGES["volume"].made)
    if path.name in SPARE and volume.is_file() and (log is None or _time(log) <= _time(volume)):
        return 1.0
    if path.name == "tets" and log is not None:  # folder with one file K-of-N.npz per part
        parts = int(log.stem.rpartition("-")[2])
        made = len(list(path.glob(f"*-of-{parts}.npz")))
        return min(made / parts, 1.0)
    if path.exists():
        return 1.0
    found = _PROGRESS.match(last_line(log)) if log else None
    return int(found[1]) / 100 if found and int(found[1]) < 100 else 0.0
