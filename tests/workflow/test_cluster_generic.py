"""The profile for PBS, with a `qsub` and a `qstat` of a few lines in its place."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROFILE = ROOT / "profiles" / "cluster-generic"
CASES = "case\tmicrostructure\tcrack\tincrements\nbare\tsynthetic\tnone\t1\n"
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
def test_a_campaign_by_qsub_asks_for_what_the_node_has(new_folder, idle_python, tmp_path, monkeypatch):
    pytest.importorskip("snakemake_executor_plugin_cluster_generic")
    for name, text in (("qsub", QSUB), ("qstat", QSTAT)):
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setenv("JOBS", str(tmp_path))
    folder = new_folder(CASES, "cases: cases.tsv\nchunks: 1\nnode: {cpus: 3, mem_mb: 1800}\n", idle_python)
    (folder.path / "profiles").symlink_to(ROOT / "profiles")
    run = folder.snakemake("--profile", str(PROFILE), "--latency-wait", "5")
    assert run.status == 0, run.text
    asked = (tmp_path / "asked").read_text()
    assert "ncpus=3:mem=1800mb -l walltime=3600 " in asked  # the job of tetrahedra
    assert (folder.path / "results" / "bare" / "000" / "model.inp").is_file()
