"""How much of a campaign's wall time no stage was at work, from the benchmark files that Snakemake writes.

A stage was at work for the seconds that its benchmark file names, up to the time when the file was written.

    python benchmarks/workflow_overhead.py            # runs examples/al1050 on two cores, then tells
    python benchmarks/workflow_overhead.py FOLDER     # of a campaign that was run in one go in FOLDER
"""

import argparse
import csv
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from craftmesh.report.case_files import STAGES

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = "examples/al1050/config.yaml"


@dataclass(frozen=True)
class Job:
    """A stage at work: its name, and begin and end in seconds of the clock."""

    stage: str
    begin: float
    end: float


def jobs_of(folder: Path) -> list[Job]:
    """Return the jobs of the campaigns under `folder`, by their benchmark files."""
    made = []
    for path in sorted(folder.glob("**/benchmarks/**/*.tsv")):
        with open(path, newline="") as stream:
            seconds = float(next(csv.DictReader(stream, delimiter="\t"))["s"])
        end = path.stat().st_mtime
        file = "tets" if path.parent.name == "tets" else path.stem
        made.append(Job(STAGES[file].verb if file in STAGES else file, end - seconds, end))
    return made


def idle(jobs: list[Job], begin: float, end: float) -> float:
    """Return the seconds between `begin` and `end` in which no job was at work."""
    gone, reached = 0.0, begin
    for job in sorted(jobs, key=lambda job: job.begin):
        gone += max(0.0, min(job.begin, end) - reached)
        reached = max(reached, job.end)
    return gone + max(0.0, end - reached)


def last_run(folder: Path) -> tuple[float, float]:
    """Return begin and end of the last run of Snakemake in `folder`, by its log."""
    log = max((folder / ".snakemake" / "log").glob("*.snakemake.log"))
    return datetime.strptime(log.name[:17], "%Y-%m-%dT%H%M%S").timestamp(), log.stat().st_mtime


def run_example(results: Path) -> tuple[float, float]:
    """Run the example on two cores and return when it began and ended."""
    begin = time.time()
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "--configfile", EXAMPLE]
    subprocess.run([*command, "--config", f"results={results}"], cwd=ROOT, check=True)
    return begin, time.time()


def tell(jobs: list[Job], begin: float, end: float):
    seconds: dict[str, list[float]] = defaultdict(list)
    for job in jobs:
        seconds[job.stage].append(job.end - job.begin)
    print("| stage | jobs | seconds |\n|---|---|---|")
    for stage, taken in sorted(seconds.items(), key=lambda item: -sum(item[1])):
        print(f"| {stage} | {len(taken)} | {sum(taken):.0f} |")
    wall, gone = end - begin, idle(jobs, begin, end)
    print(f"\n{wall:.0f} s of wall time, {gone:.1f} s of them without a stage at work: {gone / wall:.1%}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, nargs="?", help="where a finished campaign was run")
    folder = parser.parse_args().folder
    if folder is not None:
        tell(jobs_of(folder), *last_run(folder))
        return
    with tempfile.TemporaryDirectory() as results:
        began, ended = run_example(Path(results))
        tell(jobs_of(Path(results)), began, ended)


if __name__ == "__main__":
    main()
