"""Snakemake runs on campaigns in temporary folders."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CONFIG = """
cases: cases.tsv
chunks: 2
generate: {shape: [16, 15, 14], grains: 5}
sizing: {l0: 1.0, l_min: 0.7, l_max: 2.5, r0: 3.0, r1: 6.0}
cracks:
  tiny: {centre: [8.0, 0.0, 7.3], radius: 3.5, growth: 1.0}
"""
CASES = "case\tmicrostructure\tcrack\tincrements\ntiny\tsynthetic\ttiny\t2\n"


@dataclass(frozen=True)
class Run:
    """What a finished Snakemake run said."""

    status: int
    text: str

    @property
    def jobs(self) -> dict[str, int]:
        """Jobs by rule, from the run's statistics; empty when there is nothing to do."""
        table = self.text.partition("Job stats:")[2].partition("\n\n")[0]
        return {rule: int(count) for rule, count in re.findall(r"^(\w+) +(\d+)$", table, re.M)}


def snakemake(
    folder: Path, *flags: str, env: dict[str, str] | None = None, python: str = sys.executable
) -> Run:
    """Run Snakemake in `folder`; `env` is added to the environment."""
    done = subprocess.run(
        [python, "-m", "snakemake", *flags],
        cwd=folder,
        env=os.environ | (env or {}),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=500,
    )
    return Run(done.returncode, done.stdout)


@dataclass(frozen=True)
class Folder:
    """A folder with a configuration and a sheet that Snakemake runs in, and the Python that it runs by."""

    path: Path
    python: str = sys.executable

    def snakemake(self, *flags: str, configfile="config.yaml", project: Path = ROOT) -> Run:
        """Run the Snakefile of `project` here; the library beside that Snakefile is the one it sees."""
        snakefile = str(project / "Snakefile")
        flags = ("-s", snakefile, *flags, "--configfile", str(configfile))
        return snakemake(self.path, *flags, python=self.python)


@pytest.fixture(scope="session")
def run_snakemake():
    """Return `snakemake(folder, *flags, env=None)`."""
    return snakemake


@pytest.fixture(scope="session")
def new_folder(tmp_path_factory):
    """Return a function that makes a campaign's folder with lines added to its configuration."""

    def make(cases: str = CASES, config: str = CONFIG, python: str = sys.executable) -> Folder:
        path = tmp_path_factory.mktemp("campaign")
        (path / "config.yaml").write_text(config)
        (path / "cases.tsv").write_text(cases)
        return Folder(path, python)

    return make


# stands for the command craftmesh where only plans matter: writes its flags into each file asked of it
IDLE = """
import json, sys
named = {
    "import": ["--image", "--labels", "--islands", "--report"],
    "assemble": ["-o", "--front-csv", "--report"],
    "check": ["--quality"],
    "solve": ["-o", "--vtu"],
    "fracture": ["-o", "--json"],
    "grow": ["-o", "--report"],
}
words = sys.argv[1:]
for flag in named.get(words[0], ["-o"]):
    with open(words[words.index(flag) + 1], "w") as stream:
        json.dump({"ended": "", "flags": words}, stream)
"""


@pytest.fixture(scope="session")
def idle_python(tmp_path_factory):
    """The path of a Python with the same packages beside which `craftmesh` ends at once."""
    folder = tmp_path_factory.mktemp("idle")
    real = Path(sys.executable)
    (folder / "bin").mkdir()
    (folder / "bin" / "python").symlink_to(real)
    for name in ("lib", "pyvenv.cfg"):
        (folder / name).symlink_to(real.parents[1] / name)
    command = folder / "bin" / "craftmesh"
    command.write_text(f"#!{real} -IS\n{IDLE}")
    command.chmod(0o755)
    return str(folder / "bin" / "python")
