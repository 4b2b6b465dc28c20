"""`craftmesh plan` tells the jobs that Snakemake plans, before and after they have run."""

import json
import subprocess
import sys
from pathlib import Path

CRAFTMESH = str(Path(sys.executable).parent / "craftmesh")
CASES = (
    "case\tmicrostructure\tcrack\tincrements\tgrowth\n"
    "a\tsynthetic\ttiny\t2\tgrow\n"
    "b\tsynthetic\tnone\t1\tprescribed\n"
)


def plan(folder: Path, *words: str) -> subprocess.CompletedProcess:
    command = [CRAFTMESH, "plan", "config.yaml", "--report", "plan.json", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


def test_the_jobs_are_those_of_snakemake(new_folder):
    folder = new_folder(CASES)
    done = plan(folder.path)
    assert done.returncode == 0, done.stderr
    told = json.loads((folder.path / "plan.json").read_text())
    jobs = folder.snakemake("--dry-run").jobs
    assert told["jobs"] == jobs.pop("total") - jobs.pop("all")
    assert told["by_rule"] == jobs
    assert set(told["cases"]["a"]["elements"]) == {"000", "001"}
    assert told["cases"]["a"]["by_rule"]["tetrahedralize"] == 4  # two increments in two chunks
    assert told["cases"]["b"]["by_rule"]["inp"] == 1 and "crack" not in told["cases"]["b"]["by_rule"]
    assert "2 increments" in done.stdout and "on 2 cores" in done.stdout
    assert not (folder.path / "results").exists()


def test_a_mistake_is_the_line_of_the_campaign(new_folder):
    folder = new_folder("case\tmicrostructure\tcrack\tincrements\na\tgone.npz\ttiny\t1\n")
    done = plan(folder.path)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith("craftmesh: error: ") and "gone.npz does not exist" in line
