"""A campaign on a real Slurm of one node: `make test-slurm`."""

import os
import re
import signal
import time
from pathlib import Path

import pytest
from one_node import CPUS, MEMORY_MB, install, one_node_slurm, reason_to_skip

ROOT = Path(__file__).resolve().parents[2]
PROFILE = str(ROOT / "profiles" / "slurm")
CASES = """case\tmicrostructure\tcrack\tincrements\tcracks.tilted.growth\tsizing.l_max
one\tsynthetic\ttilted\t3\t0.4\t
two\tsynthetic\ttilted\t3\t0.5\t2.5
"""
WITHIN = 3600  # seconds: a level of jobs takes 10 to 40
pytestmark = pytest.mark.skipif(
    not os.environ.get("CRAFTMESH_TEST_SLURM"), reason="`make test-slurm` alone installs and starts a Slurm"
)


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    """A Slurm of one node of two processors and 6 GB."""
    reason = reason_to_skip() or install()
    if reason:
        pytest.skip(reason)
    with one_node_slurm(tmp_path_factory.mktemp("slurm")):
        yield


def wait_for(path: Path, process, folder):
    """Return as soon as a file is there that a running campaign makes."""
    began = time.monotonic()
    while not path.exists():
        assert process.poll() is None and time.monotonic() - began < WITHIN, folder.said()
        time.sleep(1)


def test_a_campaign_killed_in_the_middle_goes_on_to_the_bytes_of_a_local_run(slurm, growing_folder):
    local, cluster = growing_folder(CASES), growing_folder(CASES)
    assert local.start("--cores", "2").wait(WITHIN) == 0, local.said()

    controller = cluster.start("--profile", PROFILE)
    wait_for(cluster.path / "results" / "one" / "001" / "gradated.vtp", controller, cluster)
    os.killpg(controller.pid, signal.SIGKILL)
    controller.wait()
    assert not (cluster.path / "results" / "report.html").exists()
    assert cluster.snakemake("--unlock").status == 0
    assert cluster.start("--profile", PROFILE).wait(WITHIN) == 0, cluster.said()

    ours, theirs = cluster.made, local.made
    assert ours.keys() == theirs.keys()
    assert len([name for name in ours if name.endswith("/model.inp")]) == 6
    assert [name for name in ours if ours[name] != theirs[name] and name != "report.html"] == []


def test_no_job_asks_for_more_than_the_node_has(slurm, growing_folder):
    run = growing_folder().snakemake("--dry-run", "--profile", PROFILE)
    assert run.status == 0, run.text
    # sizes of files that are not there yet are taken for those of large models: a solution of 8 GB
    assert max(map(int, re.findall(r"mem_mb=(\d+)", run.text))) == MEMORY_MB
    assert max(map(int, re.findall(r"threads: (\d+)", run.text)), default=1) <= CPUS
