"""Snakemake's dry runs in children of a process that has it imported: 1.0 CPU s each in place of 4.5."""

import multiprocessing
import os
import sys
from pathlib import Path

_SERVER = multiprocessing.get_context("forkserver")
# what the Snakefile imports, beside Snakemake
_SERVER.set_forkserver_preload(
    ["snakemake.cli", *(f"craftmesh.campaign.{name}" for name in ("campaign", "needs", "node", "record"))]
)


def dry_run(folder: Path, flags: tuple[str, ...], said: Path, seconds: float) -> tuple[int, str]:
    """Return the status and the text of `snakemake FLAGS` in a folder; said: a file for the text."""
    child = _SERVER.Process(target=_snakemake, args=(folder, flags, said))
    child.start()
    child.join(seconds)
    if child.exitcode is None:
        child.kill()
        raise TimeoutError(f"snakemake {' '.join(flags)} takes over {seconds} s")
    return child.exitcode, said.read_text()


def _snakemake(folder: Path, flags: tuple[str, ...], said: Path) -> None:
    from snakemake import cli

    stream = open(said, "w", buffering=1)
    for number in (1, 2):
        os.dup2(stream.fileno(), number)
    sys.stdout = sys.stderr = stream
    os.chdir(folder)
    sys.argv = ["snakemake", *flags]
    cli.main(list(flags))
