"""Where the workflow and the demo are installed, when the demo runs, and which jobs a dry run plans."""

import functools
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from craftmesh.errors import CraftmeshError
from craftmesh.extras import extra
from craftmesh.io.yaml_file import read_yaml

PACKAGE = Path(__file__).parents[1]
NO_CONFIG = str(Path(__file__).with_name("no-config.yaml"))
DEFAULT = Path("config", "config.yaml")
# Configuration keys that only set where and how a campaign runs; with any other key a configuration
# describes a whole campaign.
RUN_KEYS = frozenset({"results", "data", "chunks", "warm", "exports", "node"})
_ERROR = "craftmesh: error: "
NOTE = "craftmesh: note: "
_MAIN = "from craftmesh.campaign.workflow_location import main; main()"


def home() -> Path:
    """Return the folder that contains `workflow` and `config`: the installed package or the checkout."""
    return PACKAGE if (PACKAGE / "workflow").is_dir() else PACKAGE.parent


def snakefile() -> Path:
    """Return the path of the workflow's Snakefile, for `snakemake -s` or a `module` statement."""
    return home() / "workflow" / "Snakefile"


def or_default(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return `config` if it describes a whole campaign, else the default campaign updated with `config`.

    A configuration describes a whole campaign if it has a key other than results, data, chunks, warm,
    exports and node; it is then returned unchanged. The default is config/config.yaml in the folder in
    which Snakemake runs. If that file is missing, the default is the installed demo with its case table.
    """
    if not RUN_KEYS.issuperset(config):
        return dict(config)
    if DEFAULT.is_file():
        return read_config(DEFAULT) | dict(config)
    demo = read_config(home() / DEFAULT)
    return demo | {"cases": str(home() / demo["cases"])} | dict(config)


def command_on_path() -> None:
    """Put the folder of this Python first on PATH, so that shells find its `craftmesh` command.

    Raises CraftmeshError if neither this folder nor the rest of PATH has the command.
    """
    beside = str(Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join([beside, os.environ.get("PATH", os.defpath)])
    if shutil.which("craftmesh") is None:
        raise CraftmeshError(
            f"the command craftmesh, which the rules call, is neither in {beside} nor on PATH; "
            f"install the package: {sys.executable} -m pip install '{home()}[all]'"
        )


def read_config(path: Path) -> dict[str, Any]:
    """Return the keys and values of a YAML configuration file; raises CraftmeshError for other content."""
    found = read_yaml(path)
    if not isinstance(found, dict):
        raise CraftmeshError(f"{path}: found {type(found).__name__}; expected keys with values")
    return found


class Job(NamedTuple):
    """A planned job: its rule, case and increment; case or increment is empty if the job has none."""

    rule: str
    case: str
    increment: str


def snakemake_command(*start: str) -> list[str]:
    """Return the words of a command that runs Snakemake with the installed workflow.

    start: Python's arguments that name the program, such as -m snakemake. Raises CraftmeshError if
    Snakemake is not installed.
    """
    with extra("workflow"):
        version("snakemake")
    # -P: Python does not import Snakemake's modules from the working folder
    return [sys.executable, "-P", *start, "-s", str(snakefile())]


def planned_jobs(flags: Sequence[str]) -> list[Job]:
    """Return the jobs that `snakemake FLAGS` would run in this folder, sorted by rule, case, increment.

    flags: words of Snakemake's command line. Jobs that make no file are left out. Raises CraftmeshError,
    with Snakemake's message, if the dry run fails.
    """
    # quiet, because printing the jobs takes as long as finding them
    command = [*snakemake_command("-c", _MAIN), "--dry-run", "--quiet", *flags]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise CraftmeshError(refusal(done.stdout + done.stderr))
    return [Job(*words) for words in json.loads(done.stdout.splitlines()[-1])]


def refusal(said: str) -> str:
    """Return the reason of a failure from Snakemake's output `said`.

    It is the first error of craftmesh in it, else the note on a locked folder, else the last 3 lines.
    """
    lines = [line for line in said.splitlines() if line.strip()]
    told = [line.removeprefix(_ERROR) for line in lines if line.startswith(_ERROR)]
    if any("cannot be locked" in line for line in lines):
        notes = [line.removeprefix(NOTE) for line in lines if line.startswith(NOTE)]
        told += [note for note in notes if note.startswith("the folder is locked")]
    return told[0] if told else f"snakemake fails: {' '.join(lines[-3:])}"


def main() -> None:
    """Run Snakemake's dry run with this command's arguments; print its jobs as JSON in the last line."""
    with extra("workflow"):
        from snakemake import api, cli

    files: list[Any] = []  # files to make; several may belong to one job
    # Snakemake's API reports the files to make, but only its command reads the flags of profiles.
    api.DAGApi.execute_workflow = functools.partialmethod(api.DAGApi.execute_workflow, updated_files=files)
    try:
        cli.main(sys.argv[1:])
    except SystemExit as end:
        if end.code:
            raise
    made = {(file.rule.name, tuple(file.rule.get_wildcards(file).items())) for file in files}
    named = [(rule, dict(wildcards)) for rule, wildcards in made]
    print(json.dumps(sorted((rule, words.get("case", ""), words.get("inc", "")) for rule, words in named)))
