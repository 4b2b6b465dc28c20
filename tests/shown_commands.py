"""The commands that the documentation shows."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "config/README.md", "benchmarks/README.md")),
    *sorted(ROOT.glob("docs/*.md")),
    *sorted(ROOT.glob("examples/*/README.md")),
]
HERE = Path(sys.executable).parent  # the commands of the environment that runs the tests
PROGRAMS = ("craftmesh", "snakemake", "make", "python", "pip", "apptainer", "ccx", "abaqus")


class Shown(NamedTuple):
    """A command of a page without its comment; those in fences are whole, others may be parts."""

    line: str
    is_whole: bool

    @property
    def words(self) -> list[str]:
        return shlex.split(self.line)


def blocks_of(text: str) -> list[list[Shown]]:
    """Return the commands of each fence in a page."""
    fences = re.findall(r"```(?:\w*)\n(.*?)```", text, flags=re.S)
    lines = [block.replace("\\\n", " ").splitlines() for block in fences]
    return [_commands(block, True) for block in lines]


def commands_of(text: str) -> list[Shown]:
    """Return the commands in a page's fences, and those within its text."""
    bare = re.sub(r"```.*?```", "", text, flags=re.S)
    parts = [*re.findall(r"`([^`]+)`", bare), *re.findall(r"\$\((craftmesh [^)]+)\)", text)]
    return [shown for block in blocks_of(text) for shown in block] + _commands(parts, False)


def run(folder: Path, line: str, programs: Path = HERE) -> str:
    """Run a line by the shell, with the commands in `programs` before all; return what it printed."""
    path = os.pathsep.join([str(programs), str(HERE), os.environ["PATH"]])
    env = os.environ | {"PATH": path, "ROOT": str(ROOT)}
    done = subprocess.run(
        line, shell=True, cwd=folder, env=env, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, f"{line}\n{done.stdout[-2000:]}\n{done.stderr[-3000:]}"
    return done.stdout


def _commands(lines: list[str], is_whole: bool) -> list[Shown]:
    plain = (" ".join(line.removeprefix("$ ").partition(" #")[0].split()) for line in lines)
    return [Shown(line, is_whole) for line in plain if line.split(" ")[0] in PROGRAMS and " " in line]
