"""A growing campaign that is killed again and again ends in the same bytes as one that was left alone."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
KILLS = 10
CONFIG = """
cases: cases.tsv
chunks: 2
generate: {shape: [14, 14, 14], grains: 3}
sizing: {l0: 1.0, l_min: 0.8, l_max: 3.0, r0: 3.0, r1: 6.0}
cracks:
  tilted: {centre: [7.0, 7.0, 7.2], normal: [0.0, 0.4, 1.0], radius: 2.6}
grow: {extension: 0.8}
"""
CASES = "case\tmicrostructure\tcrack\tincrements\tgrowth\ntiny\tsynthetic\ttilted\t2\tgrow\n"
COMMAND = [str(Path(sys.executable).parent / "snakemake"), "-s", str(ROOT / "Snakefile")]
FLAGS = ["--configfile", "config.yaml", "--cores", "2"]


def start(folder: Path) -> subprocess.Popen:
    """Start the campaign in a process group of its own."""
    with open(folder / "said.txt", "a") as stream:
        return subprocess.Popen(
            [*COMMAND, *FLAGS], cwd=folder, stdout=stream, stderr=stream, start_new_session=True
        )


def finish(folder: Path) -> float:
    """Run the campaign to its end and return how long it took."""
    began = time.monotonic()
    assert start(folder).wait(1500) == 0, (folder / "said.txt").read_text()[-3000:]
    return time.monotonic() - began


def kill_after(folder: Path, seconds: float) -> bool:
    """Start the campaign and kill all its processes after some seconds; False if it ended before."""
    process = start(folder)
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return True
    return False


def made(folder: Path) -> dict[str, bytes]:
    """Return the bytes of all results by path, without logs and times."""
    results = folder / "results"
    files = [path for path in sorted(results.rglob("*")) if path.is_file()]
    names = {str(path.relative_to(results)): path for path in files}
    return {
        name: path.read_bytes()
        for name, path in names.items()
        if not name.startswith(("logs/", "benchmarks/"))
    }


@pytest.mark.slow
def test_killed_at_random_points_it_goes_on_to_the_same_bytes(new_folder):
    alone, killed = (new_folder(CASES, CONFIG).path for _ in range(2))
    taken = finish(alone)
    draw = random.Random(13)
    kills = 0
    while kills < KILLS:
        # ten are spread over the time that the whole takes; Snakemake itself starts in some 3 s
        kills += kill_after(killed, 3 + draw.uniform(0, 2 * taken / KILLS))
        subprocess.run([*COMMAND, *FLAGS, "--unlock"], cwd=killed, check=True, capture_output=True)
        if (killed / "results" / "report.html").exists():
            break
    finish(killed)
    ours, theirs = made(killed), made(alone)
    assert ours.keys() == theirs.keys()
    assert [name for name in ours if ours[name] != theirs[name]] == []
    assert kills >= KILLS // 2  # ten, unless it was done before
