"""The time in which no stage is at work, from benchmark files whose times are known."""

import os
import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "workflow_overhead.py"
START = 1_700_000_000


def test_gaps_between_stages_are_counted_once(tmp_path):
    logs = tmp_path / ".snakemake" / "log"
    logs.mkdir(parents=True)
    began = subprocess.run(
        ["date", "-d", f"@{START}", "+%Y-%m-%dT%H%M%S"], capture_output=True, text=True
    ).stdout.strip()
    log = logs / f"{began}.123456.snakemake.log"
    log.touch()
    os.utime(log, (START + 100, START + 100))
    # idle from 0 to 10, and from 60 to 100: two stages overlap, and one lies within another
    for stage, begin, end in (("crack", 10, 40), ("sizing", 30, 60), ("surface", 35, 50)):
        path = tmp_path / "results" / "benchmarks" / "one" / "000" / f"{stage}.tsv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"s\th:m:s\n{end - begin}.0\t-\n")
        os.utime(path, (START + end, START + end))
    done = subprocess.run([sys.executable, str(SCRIPT), str(tmp_path)], capture_output=True, text=True)
    assert "100 s of wall time, 50.0 s of them without a stage at work: 50.0%" in done.stdout, done.stderr
    assert "| size | 1 | 30 |" in done.stdout
