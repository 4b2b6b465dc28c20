"""Reading of a case's results folder: its record, increments, costs and failures."""

import csv
import hashlib
import platform
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import front_table, read_front
from craftmesh.io.json_file import read_json, write_json
from craftmesh.io.npz import read_crystals
from craftmesh.io.stage_npz import read_sizing, read_solution
from craftmesh.io.vtk import read_crack
from craftmesh.report.sweeps import SIZES
from craftmesh.types import Crack, Crystal


class Stage(NamedTuple):
    """A stage: its subcommand, and the file that it makes in the folder of a case or increment."""

    verb: str
    made: str


# Stages by the names of their logs and benchmarks, in the order in which they run.
STAGES = {
    "generated": Stage("generate", "generated.npz"),
    "microstructure": Stage("import", "labels.npz"),
    "remeshed": Stage("remesh", "remeshed.vtp"),
    "crack": Stage("crack", "crack.vtp"),
    "sizing": Stage("size", "sizing.npz"),
    "surface": Stage("stitch", "surface.vtp"),
    "gradated": Stage("gradate", "gradated.vtp"),
    "tets": Stage("tetrahedralize", "tets"),
    "volume": Stage("assemble", "volume.vtu"),
    "renewed": Stage("renew", "volume.vtu"),
    "model": Stage("inp", "model.inp"),
    "quality": Stage("check", "quality.json"),
    "solution": Stage("solve", "solution.npz"),
    "fracture": Stage("fracture", "fracture.json"),
    "growth": Stage("grow", "growth.json"),
    "pictures": Stage("depict", "pictures"),
}
RECORD = "case.json"
PICTURES = ("grains", "sizes", "crack", "renewed", "deformed", "stress", "slip")
PACKAGES = ("craftmesh", "tetgen", "pytetwild", "numpy", "scipy", "numba", "pyamg", "snakemake")
ERROR = "craftmesh: error: "


class Cost(NamedTuple):
    """Cost of all jobs of a stage in a case.

    seconds: wall time; longest: wall seconds of the longest job; memory: MB of the largest job.
    """

    stage: str
    jobs: int
    seconds: float
    cpu_seconds: float
    longest: float
    memory: float


def stage_costs(folder: Path, increments: list[str]) -> list[Cost]:
    """Return the costs of a case's stages, in the order in which they run, from its benchmark `folder`.

    increments: names of the increments to include; jobs before the increments are always included. Files
    without the needed columns, from other versions of Snakemake, are left out. Unknown stages are last.
    """
    found: dict[str, list[dict[str, float]]] = {}
    for increment, stage, _, row in job_costs(folder):
        if increment in ("", *increments):
            found.setdefault(stage, []).append(row)
    verbs = [stage.verb for stage in STAGES.values()]
    stages = sorted(found, key=lambda stage: verbs.index(stage) if stage in verbs else len(verbs))
    return [
        Cost(
            stage,
            len(rows),
            sum(row["s"] for row in rows),
            sum(row["cpu_time"] for row in rows),
            max(row["s"] for row in rows),
            max(row["max_rss"] for row in rows),
        )
        for stage, rows in ((stage, found[stage]) for stage in stages)
    ]


def job_costs(folder: Path) -> Iterator[tuple[str, str, float, dict[str, float]]]:
    """Yield for each job: increment ("" for none), subcommand, fraction of the stage's work, and costs.

    The fraction is 1 / n for one of n chunks of grains. The costs are a dict of s (wall seconds), cpu_time
    (seconds) and max_rss (MB). folder: the case's folder of benchmark files.
    """
    for path in sorted(folder.rglob("*.tsv")):
        *places, name = path.relative_to(folder).with_suffix("").parts
        part = 1 / int(name.rpartition("-of-")[2]) if len(places) > 1 else 1.0
        name = places[1] if len(places) > 1 else name
        stage = STAGES[name].verb if name in STAGES else name
        yield from ((places[0] if places else "", stage, part, row) for row in _rows(path))


def _rows(path: Path) -> Iterator[dict[str, float]]:
    """Yield s, cpu_time and max_rss of each run in a benchmark file; numbers not measured are 0.

    Very short jobs have no measured memory.
    """
    with open(path, newline="", encoding="utf-8") as stream:
        for row in csv.DictReader(stream, delimiter="\t"):
            if {"s", "cpu_time", "max_rss"} <= row.keys():
                yield {key: _number(row[key]) for key in ("s", "cpu_time", "max_rss")}


def _number(text: str | None) -> float:
    try:
        return float(text or 0)
    except ValueError:  # "NA" or "-", if a job ended before it was measured
        return 0.0


@dataclass(frozen=True)
class Increment:
    """The results of an increment, from its files; None or empty if a file does not exist.

    quality: quality.json; lengths: of the sizing function (paper, Eq. 3) by name (SIZES); front: columns of
    sif.csv; growth: growth.json; crack: crack.vtp; size: crack size in fracture.json; reaction: half the
    sum of the reactions' absolute values, along the axis where this is largest; history: columns of the
    load history, as in `Solution`; at_fronts: entries "front ..." of the solution's record; pictures: .svg
    texts by name; opened: opened.webp; scene: scene.json; digests: SHA-256 of files by name.
    """

    name: str
    quality: Mapping[str, Any]
    lengths: Mapping[str, float]
    front: Mapping[str, np.ndarray] | None
    growth: Mapping[str, Any] | None
    crack: Crack | None
    size: float | None
    reaction: float | None
    history: Mapping[str, np.ndarray]
    at_fronts: Mapping[str, float]
    pictures: Mapping[str, str]
    opened: bytes | None
    scene: Mapping[str, Any] | None
    digests: Mapping[str, str]


@dataclass(frozen=True)
class Case:
    """A case and its increments.

    record: case.json; imported: import.json, {} if it does not exist; crystals: by phase number; digests:
    SHA-256 of files by name; costs: by stage.
    """

    name: str
    record: Mapping[str, Any]
    imported: Mapping[str, Any]
    crystals: Mapping[int, Crystal]
    digests: Mapping[str, str]
    increments: list[Increment]
    costs: list[Cost]


def read_cases(results: Path) -> list[Case]:
    """Return the cases of all campaigns in a results folder, sorted by name."""
    return [read_case(path.parent) for path in sorted(results.glob(f"*/{RECORD}"))]


def read_case(folder: Path) -> Case:
    """Return the case in a folder, with its increments up to the first that has no quality.json.

    Increments after the one in which the crack stopped are from an earlier run, and are left out. Raises
    CraftmeshError for files that cannot be read.
    """
    record = read_json(folder / RECORD)
    increments: list[Increment] = []
    for number in range(record["increments"]):
        place = folder / f"{number:03d}"
        if not (place / "quality.json").is_file():
            break
        increments.append(_increment(place))
        if has_ended(record, increments[-1]):
            break
    report, labels = folder / "import.json", folder / "labels.npz"
    return Case(
        name=folder.name,
        record=record,
        imported=read_json(report) if report.is_file() else {},
        crystals=read_crystals(labels) if labels.is_file() else {},
        digests=_digests(folder, (labels.name,)),
        increments=increments,
        costs=stage_costs(folder.parent / "benchmarks" / folder.name, [inc.name for inc in increments]),
    )


def has_ended(record: Mapping[str, Any], increment: Increment) -> bool:
    """Return True if the crack of a case stops after the increment; False if the crack is prescribed.

    record: of the case, case.json.
    """
    return record["growth"] != "prescribed" and bool(increment.growth and increment.growth["ended"])


def is_complete(case: Case) -> bool:
    """Return True if a case has as many increments as case.json asks for, or its crack has stopped."""
    done = case.increments
    return len(done) == case.record["increments"] or bool(done and has_ended(case.record, done[-1]))


def _increment(folder: Path) -> Increment:
    path = folder / "solution.npz"
    solution = read_solution(path) if path.is_file() else None
    record = {} if solution is None else solution.record
    scene, opened = (folder / "pictures" / name for name in ("scene.json", "opened.webp"))
    fracture, growth = folder / "fracture.json", folder / "growth.json"
    sizing, front, crack = (folder / name for name in ("sizing.npz", "sif.csv", "crack.vtp"))
    drawn = {name: folder / "pictures" / f"{name}.svg" for name in PICTURES}
    lengths = read_sizing(sizing) if sizing.is_file() else {}
    return Increment(
        name=folder.name,
        quality=read_json(folder / "quality.json"),
        lengths={name: float(lengths[name]) for name in SIZES if lengths},
        front=front_with_flags(front),
        growth=read_json(growth) if growth.is_file() else None,
        crack=read_crack(crack) if crack.is_file() else None,
        size=read_json(fracture).get("growth", {}).get("size") if fracture.is_file() else None,
        reaction=None if solution is None else float(np.abs(solution.reactions).sum(axis=0).max() / 2),
        history={} if solution is None else solution.history,
        at_fronts={name: float(x) for name, x in record.items() if name.startswith("front ")},
        pictures={name: path.read_text(encoding="utf-8") for name, path in drawn.items() if path.is_file()},
        opened=opened.read_bytes() if opened.is_file() else None,
        scene=read_json(scene) if scene.is_file() else None,
        digests=_digests(folder, ("model.inp", "model_mesh.inp", "volume.vtu")),
    )


def front_with_flags(path: Path) -> dict[str, np.ndarray] | None:
    """Return the columns of a sif.csv; None if the file does not exist or has no rows (no front left).

    Without a column flags, it is added with empty words.
    """
    table = front_table(path) if path.is_file() else None
    if table is None or not table.rows:
        return None
    flags = table.words("flags") or [""] * len(table.rows)
    return read_front(path) | {"flags": np.array(flags)}


def _digests(folder: Path, names: tuple[str, ...]) -> dict[str, str]:
    found = {}
    for name in names:
        if (folder / name).is_file():
            with open(folder / name, "rb") as stream:
                found[name] = hashlib.file_digest(stream, "sha256").hexdigest()
    return found


def versions() -> dict[str, str]:
    """Return the versions of Python and of the installed PACKAGES, by name."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return {"python": platform.python_version(), **found}


class Failure(NamedTuple):
    """A failure of an incomplete case.

    log: path of a log that ends in an error, relative to the folder of logs, "" if there is none; line: its
    last line, without the prefix ERROR.
    """

    case: str
    log: str
    line: str


def failures(case: Case, results: Path) -> list[Failure]:
    """Return the errors at the ends of an incomplete case's logs; [] if the case is complete.

    If no log ends in an error, one entry says so: the jobs wait, run or were killed.
    """
    if is_complete(case):
        return []
    told = log_errors(results, case.name)
    return told or [Failure(case.name, "", "not made yet, and no log ends in an error")]


def log_errors(results: Path, case: str, since: float = 0.0) -> list[Failure]:
    """Return the errors at the ends of a case's logs, one per log that ends in an error.

    Logs last changed before `since` (seconds since 1970) are left out. Each job overwrites its log, so a
    stage that succeeded later has no error.
    """
    logs = results / "logs"
    found = [(path, last_line(path)) for path in sorted((logs / case).rglob("*.log"))]
    return [
        Failure(case, str(path.relative_to(logs)), line.removeprefix(ERROR))
        for path, line in found
        if line.startswith(ERROR) and path.stat().st_mtime >= since
    ]


def last_line(path: Path) -> str:
    """Return the last non-blank line of a text file, "" if there is none."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    return next((line for line in reversed(lines) if line.strip()), "")


def write_records(results: Path, asked: Mapping[str, Any], campaign: str = "the campaign") -> None:
    """Write a record (RECORD) with configuration and versions into the folder of each case of a campaign.

    asked: a mapping with the keys campaign, config and cases, as the workflow writes it; campaign: name for
    messages. Deletes the records of cases of this campaign that are no longer in its case table. Raises
    CraftmeshError if a key is missing.
    """
    if not {"campaign", "config", "cases"} <= asked.keys():
        raise CraftmeshError(
            f"{campaign}: has the keys {', '.join(asked) or 'none'}; expected campaign, config and cases,"
            " as the workflow writes them; leave --campaign out for cases that have been reported before"
        )
    for path in results.glob(f"*/{RECORD}"):  # for cases that are no longer in the table
        if path.parent.name not in asked["cases"] and read_json(path).get("campaign") == asked["campaign"]:
            path.unlink()
    for name, case in asked["cases"].items():
        config = asked["config"] | case["settings"]
        config["cracks"] = {crack: config["cracks"][crack] for crack in case["cracks"]}
        told = {key: value for key, value in case.items() if key != "settings"}
        record = {"campaign": asked["campaign"], **told, "config": config, "versions": versions()}
        write_json(results / name / RECORD, record)
