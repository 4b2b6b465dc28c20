"""The profile for PBS and LSF, with their commands of a few lines in place of the real ones."""

import os
import re
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
PROFILE = ROOT / "profiles" / "cluster-generic"
CASES = "case\tmicrostructure\tcrack\tincrements\nbare\tsynthetic\tnone\t1\n"
QUICK = ("--latency-wait", "5", "--seconds-between-status-checks", "1")
# runs the script of the last word as the cluster would: in this folder, as a program
RUN = """#!/bin/sh
for script; do :; done
number=$(date +%N | sed 's/^0*//')
echo "$@" >> "$JOBS/asked"
{ "$script" > /dev/null 2>&1; echo $? > "$JOBS/$number"; } > /dev/null 2>&1 &
"""
QSTAT = """#!/bin/sh
if [ -f "$JOBS/$3" ]; then echo "    job_state = F"; echo "    Exit_status = $(cat "$JOBS/$3")"
else echo "    job_state = R"; fi
"""
BJOBS = """#!/bin/sh
state=RUN
if [ -f "$JOBS/$1" ]; then if [ "$(cat "$JOBS/$1")" = 0 ]; then state=DONE; else state=EXIT; fi; fi
echo "JOBID   USER    STAT  QUEUE      FROM_HOST   EXEC_HOST   JOB_NAME   SUBMIT_TIME"
echo "$1   root    $state  normal     here        there       a name     Nov 22 20:00"
"""


class Cluster(NamedTuple):
    """A batch system: its commands, and how it is asked for processors, memory and time."""

    programs: dict[str, str]
    asked: str
    time_unit: int  # seconds


PBS = Cluster(
    {"qsub": RUN + "echo $number\n", "qstat": QSTAT}, r"ncpus=(\d+):mem=(\d+)mb -l walltime=(\d+) ", 1
)
LSF = Cluster(
    {"bsub": RUN + 'echo "Job <$number> is submitted to queue <normal>."\n', "bjobs": BJOBS},
    r"-n (\d+) -M (\d+)MB -W (\d+) -R span\[hosts=1\] rusage\[mem=\2MB\] ",
    60,
)


def profile_of(cluster: Cluster, folder: Path) -> Path:
    """Return the profile, for LSF with its lines, which are comments, in place of those for PBS."""
    text = (PROFILE / "config.yaml").read_text()
    if cluster is PBS:
        return PROFILE
    lines = text.partition("# LSF")[2].partition("\n\n")[0].splitlines()[1:]
    instead = yaml.safe_load("\n".join(line.removeprefix("# ") for line in lines))
    assert instead.keys() == {key for key in yaml.safe_load(text) if key.startswith("cluster-generic")}
    (folder / "profile").mkdir()
    (folder / "profile" / "config.yaml").write_text(yaml.safe_dump(yaml.safe_load(text) | instead))
    return folder / "profile"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Return a function that puts a cluster's commands on the PATH; their notes are in the folder."""

    def put(cluster):
        for name, text in cluster.programs.items():
            (tmp_path / name).write_text(text)
            (tmp_path / name).chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
        monkeypatch.setenv("JOBS", str(tmp_path))
        return tmp_path

    return put


@pytest.mark.slow
@pytest.mark.parametrize("cpus, jobs", [(3, 6), (1, 7)])
@pytest.mark.parametrize("cluster", [PBS, LSF], ids=["pbs", "lsf"])
def test_a_campaign_asks_for_what_the_node_has(new_folder, idle_python, place, cluster, cpus, jobs):
    notes = place(cluster)
    node = f"{{cpus: {cpus}, mem_mb: 1800}}"
    folder = new_folder(CASES, f"cases: cases.tsv\nchunks: 1\nnode: {node}\n", idle_python)
    (folder.path / "profiles").symlink_to(ROOT / "profiles")
    run = folder.snakemake("--profile", str(profile_of(cluster, notes)), *QUICK)
    assert run.status == 0, run.text
    asked = re.findall(cluster.asked, (notes / "asked").read_text())
    most = [max(map(int, numbers)) for numbers in zip(*asked)]
    assert len(asked) == jobs and most[:2] == [cpus, 1800] and most[2] * cluster.time_unit > 3600
    assert (folder.path / "results" / "bare" / "000" / "model.inp").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("cluster", [PBS, LSF], ids=["pbs", "lsf"])
def test_a_job_that_the_cluster_ends_is_noticed_and_tried_again(new_folder, idle_python, place, cluster):
    notes = place(cluster)
    submit = notes / ("qsub" if cluster is PBS else "bsub")
    kill_first = 'test -f "$JOBS/killed" || { touch "$JOBS/killed"; script=false; }\nnumber='
    submit.write_text(submit.read_text().replace("number=", kill_first, 1))
    folder = new_folder(CASES, "cases: cases.tsv\nchunks: 1\nnode: {cpus: 3, mem_mb: 16000}\n", idle_python)
    (folder.path / "profiles").symlink_to(ROOT / "profiles")
    run = folder.snakemake("--profile", str(profile_of(cluster, notes)), *QUICK)
    assert run.status == 0, run.text
    asked = re.findall(cluster.asked, (notes / "asked").read_text())
    first, again = ([int(number) for number in numbers] for numbers in asked[:2])
    assert again[1:] == [2 * first[1], 2 * first[2]]
