"""Snakemake runs on campaigns in temporary folders."""

import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from dry_runs import dry_run

ROOT = Path(__file__).resolve().parents[2]
CONFIG = """
cases: cases.tsv
chunks: 2
generate: {shape: [12, 9, 8], grains: 3}
sizing: {l0: 1.5, l_min: 1.0, l_max: 3.0, r0: 2.0, r1: 4.0}
cracks:
  tiny: {centre: [6.0, 0.0, 4.2], radius: 3.5, growth: 1.0}
"""
CASES = "case\tmicrostructure\tcrack\tincrements\ntiny\tsynthetic\ttiny\t2\n"
# the smallest closed loop: a tilted penny that turns, two increments of seconds each
GROWING_CONFIG = """
cases: cases.tsv
chunks: 1
generate: {shape: [12, 12, 12], grains: 2}
sizing: {l0: 1.5, l_min: 0.8, l_max: 3.0, r0: 2.0, r1: 4.0}
cracks:
  tilted: {centre: [6.0, 6.0, 6.2], normal: [0.0, 0.4, 1.0], radius: 2.6}
grow: {extension: 0.8}
"""
GROWING_CASES = "case\tmicrostructure\tcrack\tincrements\tgrowth\ntiny\tsynthetic\ttilted\t2\tgrow\n"


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
    folder: Path,
    *flags: str,
    env: dict[str, str] | None = None,
    python: str = sys.executable,
    other_library: bool = False,
) -> Run:
    """Run Snakemake in `folder`; `env` is added to the environment.

    other_library: whether it finds another craftmesh than this process.
    """
    if "--dry-run" in flags and not env and python == sys.executable and not other_library:
        with tempfile.TemporaryDirectory() as aside:
            return Run(*dry_run(folder, flags, Path(aside) / "said", 500))
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

    @property
    def made(self) -> dict[str, bytes]:
        """The bytes of all complete results by path, without logs, and of the report without times."""
        results = self.path / "results"
        files = [path for path in sorted(results.rglob("*")) if path.is_file()]
        names = {str(path.relative_to(results)): path for path in files}
        return {
            name: re.sub(b"<!--times-->.*?<!--/times-->", b"", path.read_bytes(), flags=re.DOTALL)
            for name, path in names.items()
            if not name.startswith(("logs/", "benchmarks/")) and "/.tmp-" not in name
        }

    def start(self, *flags: str) -> subprocess.Popen:
        """Start Snakemake in a process group of its own; what it says is added to said.txt."""
        command = [self.python, "-m", "snakemake", "-s", str(ROOT / "Snakefile"), *flags]
        with open(self.path / "said.txt", "a") as stream:
            return subprocess.Popen(
                [*command, "--configfile", "config.yaml"],
                cwd=self.path,
                stdout=stream,
                stderr=stream,
                start_new_session=True,
            )

    def said(self) -> str:
        """Return the end of what the runs that were started said."""
        return (self.path / "said.txt").read_text()[-3000:]

    def snakemake(self, *flags: str, configfile="config.yaml", project: Path = ROOT) -> Run:
        """Run the Snakefile of `project` here; the library beside that Snakefile is the one it sees."""
        snakefile = str(project / "Snakefile")
        flags = ("-s", snakefile, *flags, "--configfile", str(configfile))
        return snakemake(self.path, *flags, python=self.python, other_library=project != ROOT)


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


@pytest.fixture(scope="session")
def growing_folder(new_folder):
    """Return a function that makes the folder of a campaign whose crack grows."""
    return lambda cases=GROWING_CASES: new_folder(cases, GROWING_CONFIG)


# stands for the command craftmesh where only plans matter: writes its flags into each file asked of it
# cracks end after the increment ENDS; where that begins with -, the growth fails there
IDLE = """
import json, os, sys
named = {
    "import": ["--image", "--labels", "--islands", "--report"],
    "assemble": ["-o", "--front-csv", "--report"],
    "check": ["--quality"],
    "solve": ["-o", "--vtu"],
    "fracture": ["-o", "--json"],
    "grow": ["-o", "--report", "--base", "--step"],
}
words = sys.argv[1:]
ends = os.environ.get("ENDS", "never")
if words[0] == "grow" and f"/{ends[1:]}/" in words[words.index("-o") + 1]:
    sys.exit("craftmesh: error: no room")
ended = "severed" * (words[0] == "grow" and f"/{ends}/" in words[words.index("-o") + 1])
if words[0] == "depict":
    os.mkdir(words[words.index("-o") + 1])
    sys.exit()
if words[0] == "report":
    asked = json.load(open(words[words.index("--campaign") + 1]))
    for name, case in asked["cases"].items():
        with open(os.path.join(words[1], name, "case.json"), "w") as stream:
            json.dump({"campaign": asked["campaign"], **case}, stream)
for flag in named.get(words[0], ["-o"]):
    with open(words[words.index(flag) + 1], "w") as stream:
        json.dump({"ended": ended, "flags": words}, stream)
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
