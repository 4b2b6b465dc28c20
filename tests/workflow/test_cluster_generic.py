"""The profile for PBS, with a `qsub` and a `qstat` of a few lines in its place."""

import os
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROFILE = ROOT / "profiles" / "cluster-generic"
CASES = "case\tmicrostructure\tcrack\tincrements\nbare\tsynthetic\tnone\t1\n"
QUICK = ("--latency-wait", "5", "--seconds-between-status-checks", "1")
QSUB = """#!/bin/sh
for script; do :; done
number=$(date +%N)
echo "$@" >> "$JOBS/asked"
{ sh "$script" > /dev/null 2>&1; echo "Exit_status = $?" > "$JOBS/$number"; } > /dev/null 2>&1 &
echo $number
"""
QSTAT = """#!/bin/sh
if [ -f "$JOBS/$3" ]; then echo "    job_state = F"; cat "$JOBS/$3"; else echo "    job_state = R"; fi
"""


@pytest.mark.slow
@pytest.mark.parametrize("cpus, jobs", [(3, 6), (1, 7)])
def test_a_campaign_by_qsub_asks_for_what_the_node_has(
    new_folder, idle_python, tmp_path, monkeypatch, cpus, jobs
):
    for name, text in (("qsub", QSUB), ("qstat", QSTAT)):
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setenv("JOBS", str(tmp_path))
    node = f"{{cpus: {cpus}, mem_mb: 1800}}"
    folder = new_folder(CASES, f"cases: cases.tsv\nchunks: 1\nnode: {node}\n", idle_python)
    (folder.path / "profiles").symlink_to(ROOT / "profiles")
    run = folder.snakemake("--profile", str(PROFILE), *QUICK)
    assert run.status == 0, run.text
    asked = re.findall(r"ncpus=(\d+):mem=(\d+)mb -l walltime=(\d+) ", (tmp_path / "asked").read_text())
    most = [max(map(int, numbers)) for numbers in zip(*asked)]
    assert len(asked) == jobs and most[:2] == [cpus, 1800] and most[2] > 3600
    assert (folder.path / "results" / "bare" / "000" / "model.inp").is_file()
