"""Run a campaign with a status line for each case: at the end also the reason of a failure.

Snakemake runs the campaign with the installed workflow and logs to the folder .snakemake/log. Words after
`--snakemake` are passed to Snakemake, as in `craftmesh run mine.yaml --snakemake -R gradate`.
"""

import argparse
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import IO

from craftmesh.campaign.case_status import Standing, case_statuses
from craftmesh.campaign.workflow_location import NOTE, read_config, refusal, snakefile, snakemake_command
from craftmesh.commands.compile import compiling_ahead
from craftmesh.commands.licence import licence_note
from craftmesh.commands.stage_io import add_config
from craftmesh.errors import INTERRUPTED, CraftmeshError, existing
from craftmesh.processes.guard import guarded, release
from craftmesh.progress import LiveLines

LOOK = 1.0  # smallest number of seconds between two readings of the cases' status
REST = 20  # smallest ratio of a pause to the duration of the last reading, which is long with many cases
_PLACE = re.compile("craftmesh: the cases of (.*), results in (.*)")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_config(parser)
    where = parser.add_mutually_exclusive_group()
    add_cores(where)
    where.add_argument(
        "--profile",
        metavar="FOLDER",
        help="Snakemake profile, for example of a cluster, instead of --cores; installed: profiles/slurm "
        "and profiles/cluster-generic",
    )
    parser.add_argument(
        "--snakemake",
        nargs=argparse.REMAINDER,
        default=[],
        metavar="WORD",
        help="flags and targets of snakemake: all words that follow",
    )


def add_cores(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "--cores", default="all", metavar="N", help="cores to use at the same time (default all)"
    )


def run(arguments: argparse.Namespace) -> int:
    profile = arguments.profile and _profile(arguments.profile)
    words = []
    if arguments.config:  # before --cores, because --configfile takes all words up to the next flag
        read_config(existing(arguments.config))
        words += ["--configfile", str(arguments.config)]
    words += ["--profile", profile] if profile else ["--cores", arguments.cores]
    with nullcontext() if profile else compiling_ahead():
        return run_snakemake([*words, *arguments.snakemake])


def _profile(given: str) -> str:
    """Return the given profile folder or, if it does not exist, that folder of the installed workflow.

    Raises CraftmeshError for a Slurm profile if there is no sbatch, because Snakemake would wait forever.
    Whether either folder exists is not checked.
    """
    installed = snakefile().parent / given
    folder = Path(given) if Path(given).exists() or not installed.is_dir() else installed
    config = folder / "config.yaml"
    if config.is_file() and read_config(config).get("executor") == "slurm" and not shutil.which("sbatch"):
        raise CraftmeshError(
            f"{config}: needs sbatch, which is not on the PATH; run on a login node or without --profile"
        )
    return str(folder)


def run_snakemake(words: Sequence[str]) -> int:
    """Run `snakemake WORDS` with the installed workflow, and return its exit status.

    While it runs, a line per case shows the status; at the end, notes and the reasons of failures are
    printed. Raises CraftmeshError if Snakemake fails although no case failed, and after an interrupt.
    """
    licence_note()
    command = [*snakemake_command("-m", "snakemake"), *words]
    begun, place = time.time(), None
    cases: list[Standing] = []
    with tempfile.NamedTemporaryFile("w") as said, _child(command, said) as child, LiveLines() as lines:
        while child.poll() is None:
            looked = time.monotonic()
            place = place or _PLACE.search(_text(said))
            cases = _cases(place, begun) or cases  # _cases finds none while the report is written
            shown = [str(one) for one in cases if one.failures or one.runs]
            lines.show([*shown, _made(cases) if cases else "planning"])
            time.sleep(max(LOOK, REST * (time.monotonic() - looked)))
        text = _text(said)
    place = place or _PLACE.search(text)
    cases = _cases(place, begun) or cases
    for line in text.splitlines():
        if line.startswith(NOTE):
            print(line)
    failed = [one for one in cases if one.failures]
    for one in failed:
        print(one)
    if child.returncode and not failed:
        raise CraftmeshError(refusal(text))
    print(_made(cases) + (f"; see {Path(place[2], 'report.html')}" if place else ""))
    return child.returncode


@contextmanager
def _child(command: Sequence[str], said: IO[str]) -> Iterator[subprocess.Popen]:
    """Yield the process of a command, which prints to the file `said` and ends when this block ends.

    Raises CraftmeshError after Ctrl-C. Changes how this process handles SIGTERM and SIGHUP: it exits.
    """
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:  # nohup ignores SIGHUP
            signal.signal(number, lambda *_: sys.exit(INTERRUPTED))
    child = guarded(command, said)
    try:
        yield child
    except KeyboardInterrupt:
        raise CraftmeshError("stopped; give the same command again to continue") from None
    finally:
        release(child)


def _text(said: IO[str]) -> str:
    return Path(said.name).read_text(encoding="utf-8", errors="replace")


def _cases(place: re.Match | None, begun: float) -> list[Standing]:
    """Return the status of the campaign's cases that have begun; [] before Snakemake prints their place.

    place: match of `_PLACE`, with case table and results folder, in Snakemake's output; begun: start of the
    run in seconds since the epoch.
    """
    return case_statuses(Path(place[2]), place[1], begun) if place else []


def _made(cases: Sequence[Standing]) -> str:
    return f"{sum(one.job is None for one in cases)} of {len(cases)} cases made"
