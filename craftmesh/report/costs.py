"""Seconds and memory of a case's jobs, from the files that Snakemake's benchmarks write."""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

# The stage that makes a file, by the file's name; others are called by the file itself.
STAGES = {
    "generated": "generate",
    "microstructure": "import",
    "remeshed": "remesh",
    "crack": "crack",
    "sizing": "size",
    "surface": "stitch",
    "gradated": "gradate",
    "tets": "tetrahedralize",
    "volume": "assemble",
    "model": "inp",
    "solution": "solve",
    "fracture": "fracture",
    "growth": "grow",
    "quality": "check",
    "pictures": "depict",
}


class Cost(NamedTuple):
    """What the jobs of a stage took: how many, seconds on the clock and of all cores, MB of the largest."""

    stage: str
    jobs: int
    seconds: float
    cpu_seconds: float
    longest: float
    memory: float


def stage_costs(folder: Path, increments: list[str]) -> list[Cost]:
    """Return the costs of a case's stages, in the order of the way, from the benchmarks in its `folder`.

    increments: names of those that count. Files that another version of Snakemake wrote, without the
    columns that are asked for, are left out.
    """
    found: dict[str, list[dict[str, float]]] = {}
    for path in sorted(folder.rglob("*.tsv")):
        inner = path.relative_to(folder).parts
        if len(inner) > 1 and inner[0] not in increments:
            continue
        name = inner[1] if len(inner) > 2 else path.name.removesuffix(".tsv")
        found.setdefault(STAGES.get(name, name), []).extend(_rows(path))
    stages = [stage for stage in STAGES.values() if stage in found]
    stages += [stage for stage in found if stage not in stages]
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
        if rows
    ]


def _rows(path: Path) -> Iterator[dict[str, float]]:
    """Yield the runs in a benchmark file; jobs shorter than its first look have no memory: 0."""
    with open(path, newline="", encoding="utf-8") as stream:
        for row in csv.DictReader(stream, delimiter="\t"):
            if {"s", "cpu_time", "max_rss"} <= row.keys():
                yield {key: _number(row[key]) for key in ("s", "cpu_time", "max_rss")}


def _number(text: str | None) -> float:
    try:
        return float(text or 0)
    except ValueError:  # "NA" and "-", where a job was over before it was looked at
        return 0.0
