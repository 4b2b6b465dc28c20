"""A growing campaign that is killed again and again ends in the same bytes as one that was left alone."""

import os
import random
import shutil
import signal
import subprocess
import time

import pytest

KILLS = 20


def finish(folder) -> float:
    """Run the campaign to its end and return how long it took."""
    began = time.monotonic()
    assert folder.start("--cores", "2").wait(1500) == 0, folder.said()
    return time.monotonic() - began


def kill_after(folder, seconds: float) -> bool:
    """Start the campaign and kill all its processes after some seconds; False if it ended well before."""
    process = folder.start("--cores", "2")
    try:
        assert process.wait(seconds) == 0, folder.said()
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return True
    return False


def check_same(folder, other):
    """Assert that two campaigns made the same files with the same bytes."""
    ours, theirs = folder.made, other.made
    assert ours.keys() == theirs.keys()
    assert [name for name in ours if ours[name] != theirs[name]] == []


@pytest.mark.slow
def test_killed_at_random_moments_it_goes_on_to_the_same_bytes(growing_folder):
    alone, killed = growing_folder(), growing_folder()
    taken = finish(alone)
    draw = random.Random(13)
    for _ in range(KILLS):
        # twenty are spread over the time that the whole takes; Snakemake itself starts in some 3 s
        while not kill_after(killed, 3 + draw.uniform(0, 2 * taken / KILLS)):
            check_same(killed, alone)
            shutil.rmtree(killed.path / "results")
        assert killed.snakemake("--unlock").status == 0
    finish(killed)
    check_same(killed, alone)
