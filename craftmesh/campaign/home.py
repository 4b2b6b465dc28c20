"""The workflow from outside: where it and the demo lie, when the demo runs, and what a dry run plans."""

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
# keys that say where and how a campaign runs; the others say which campaign it is
RUN_KEYS = frozenset({"results", "data", "chunks", "warm", "exports", "node"})
_ERROR = "craftmesh: error: "
NOTE = "craftmesh: note: "
_MAIN = "from craftmesh.campaign.home import main; main()"


def home() -> Path:
    """Return the folder that holds `workflow` and `config`: the installed package or the checkout."""
    return PACKAGE if (PACKAGE / "workflow").is_dir() else PACKAGE.parent


def snakefile() -> Path:
    """Return the workflow's Snakefile, to be given to `snakemake -s` or to `module`."""
    return home() / "workflow" / "Snakefile"


def or_default(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return `config` where it names a campaign, else the default campaign with `config` laid over it.

    A campaign is named by any key but results, data, chunks, warm, exports and node; it never takes over
    values of the default one. The default is config/config.yaml in the folder in which Snakemake runs, or
    else the demo, whose sheet of cases lies beside it.
    """
    if not RUN_KEYS.issuperset(config):
        return dict(config)
    if DEFAULT.is_file():
        return read_config(DEFAULT) | dict(config)
    demo = read_config(home() / DEFAULT)
    return demo | {"cases": str(home() / demo["cases"])} | dict(config)


def command_on_path() -> None:
    """Let shells find the `craftmesh` command that lies beside this Python.

    Raises CraftmeshError where there is none, neither there nor elsewhere on the path.
    """
    beside = str(Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join([beside, os.environ.get("PATH", os.defpath)])
    if shutil.which("craftmesh") is None:
        raise CraftmeshError(
            f"the command craftmesh is not in {beside} nor on the path, but the rules call it; "
            f"install the package: {sys.executable} -m pip install '{home()}[all]'"
        )


def read_config(path: Path) -> dict[str, Any]:
    """Return what a configuration file holds; raises CraftmeshError for what is not YAML with keys."""
    found = read_yaml(path)
    if not isinstance(found, dict):
        raise CraftmeshError(f"{path}: found {type(found).__name__}; expected keys with values")
    return found


class Job(NamedTuple):
    """A planned job: its rule, its case and increment, empty where it has none."""

    rule: str
    case: str
    increment: str


def snakemake_command(*start: str) -> list[str]:
    """Return the words that run Snakemake with the installed workflow, as Python runs what `start` names.

    Raises CraftmeshError where Snakemake is not installed.
    """
    with extra("workflow"):
        version("snakemake")
    # -P: modules of this folder are none of Snakemake's
    return [sys.executable, "-P", *start, "-s", str(snakefile())]


def planned_jobs(flags: Sequence[str]) -> list[Job]:
    """Return the jobs that `snakemake FLAGS` would run in this folder, by rule, case and increment.

    Those that only gather files are left out. Raises CraftmeshError as Snakemake does.
    """
    # quiet: telling jobs takes as long as finding them
    command = [*snakemake_command("-c", _MAIN), "--dry-run", "--quiet", *flags]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise CraftmeshError(refusal(done.stdout + done.stderr))
    return [Job(*words) for words in json.loads(done.stdout.splitlines()[-1])]


def refusal(said: str) -> str:
    """Return why Snakemake ended, from what it said: the workflow's error, else its last three lines."""
    lines = [line for line in said.splitlines() if line.strip()]
    told = [line.removeprefix(_ERROR) for line in lines if line.startswith(_ERROR)]
    if any("cannot be locked" in line for line in lines):
        notes = [line.removeprefix(NOTE) for line in lines if line.startswith(NOTE)]
        told += [note for note in notes if note.startswith("the folder is locked")]
    return told[0] if told else f"snakemake fails: {' '.join(lines[-3:])}"


def main() -> None:
    """Run Snakemake with this command's words, a dry run, and print its jobs as JSON in the last line."""
    with extra("workflow"):
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
