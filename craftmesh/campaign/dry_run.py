"""What Snakemake would run, told by its own dry run."""

import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from craftmesh.campaign.home import snakefile
from craftmesh.errors import CraftmeshError

# jobs of a group stand further in
_JOB = re.compile(r"^( *)(?:local)?(?:rule|checkpoint) (\w+):$((?:\n\1    .*)*)", re.M)
_WILDCARDS = re.compile(r"^ *wildcards: (.*)$", re.M)
_ERROR = "craftmesh: error: "


@dataclass(frozen=True)
class Job:
    """A planned job: its rule, its case and increment, empty where it has none."""

    rule: str
    case: str
    increment: str


def planned_jobs(flags: Sequence[str]) -> list[Job]:
    """Return the jobs that `snakemake FLAGS` would run in this folder; raises CraftmeshError as it does."""
    snakemake = Path(sys.executable).with_name("snakemake")
    command = [str(snakemake), "-s", str(snakefile()), "--dry-run", *flags]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        lines = [line for line in done.stdout.splitlines() if line.strip()]
        told = [line.removeprefix(_ERROR) for line in lines if line.startswith(_ERROR)]
        raise CraftmeshError(told[0] if told else f"snakemake --dry-run fails: {' '.join(lines[-3:])}")
    return jobs_of(done.stdout)


def jobs_of(text: str) -> list[Job]:
    """Return the jobs that a dry run prints, but for those that only gather files."""
    jobs = []
    for _, rule, body in _JOB.findall(text):
        found = _WILDCARDS.search(body)
        words = dict(pair.split("=", 1) for pair in found.group(1).split(", ")) if found else {}
        if rule != "all":
            jobs.append(Job(rule, words.get("case", ""), words.get("inc", "")))
    return jobs
