"""What Snakemake would run, told by its own dry run."""

import functools
import json
import subprocess
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

from craftmesh.campaign.home import snakefile
from craftmesh.errors import CraftmeshError

_ERROR = "craftmesh: error: "
_MAIN = "from craftmesh.campaign.dry_run import main; main()"


class Job(NamedTuple):
    """A planned job: its rule, its case and increment, empty where it has none."""

    rule: str
    case: str
    increment: str


def planned_jobs(flags: Sequence[str]) -> list[Job]:
    """Return the jobs that `snakemake FLAGS` would run in this folder, by rule, case and increment.

    Those that only gather files are left out. Raises CraftmeshError as Snakemake does.
    """
    # -P: modules of this folder are none of Snakemake's; quiet: telling jobs takes as long as finding them
    command = [sys.executable, "-P", "-c", _MAIN, "-s", str(snakefile()), "--dry-run", "--quiet", *flags]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        told = [line.removeprefix(_ERROR) for line in lines if line.startswith(_ERROR)]
        raise CraftmeshError(told[0] if told else f"snakemake --dry-run fails: {' '.join(lines[-3:])}")
    return [Job(*words) for words in json.loads(done.stdout.splitlines()[-1])]


def main() -> None:
    """Run Snakemake with this command's words, a dry run, and print its jobs as JSON in the last line."""
    from snakemake import api, cli

    files: list[Any] = []  # one or several of each job
    # what is to be made is told by Snakemake's API alone, but the flags of profiles by its command alone
    api.DAGApi.execute_workflow = functools.partialmethod(api.DAGApi.execute_workflow, updated_files=files)
    try:
        cli.main(sys.argv[1:])
    except SystemExit as end:
        if end.code:
            raise
    made = {(file.rule.name, tuple(file.rule.get_wildcards(file).items())) for file in files}
    named = [(rule, dict(wildcards)) for rule, wildcards in made]
    print(json.dumps(sorted((rule, words.get("case", ""), words.get("inc", "")) for rule, words in named)))
