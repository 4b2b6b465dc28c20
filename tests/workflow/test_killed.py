"""A growing campaign that is killed again and again ends in the same bytes as one that was left alone."""

import csv
import os
import random
import shutil
import signal
import time
from collections.abc import Callable
from functools import partial

import pytest

KILLS = 20
AIMED_KILLS = 4
STARTS_IN = 3  # seconds, until Snakemake's first job
# three increments: the second step corrects the first
CASES = "case\tmicrostructure\tcrack\tincrements\tgrowth\ntiny\tsynthetic\ttilted\t3\tgrow\n"
FLAGS = ("--cores", "2")
WITHIN = 1500  # seconds, of the whole campaign


def finish(folder):
    """Run the campaign to its end."""
    assert folder.start(*FLAGS).wait(WITHIN) == 0, folder.said()


def ended_jobs(folder) -> int:
    return len(list(folder.path.glob("results/benchmarks/**/*.tsv")))


def has_ended(folder, count: int) -> bool:
    return ended_jobs(folder) >= count


def kill_after(folder, is_reached: Callable[[], bool], seconds: float, earliest: float = 0.0) -> bool:
    """Start the campaign and kill all that it runs some seconds after a state; False if it ended before.

    earliest: seconds from the start before which the state is not looked for.
    """
    process = folder.start(*FLAGS)
    began, reached = time.monotonic(), None
    while process.poll() is None:
        now = time.monotonic()
        assert now - began < WITHIN, folder.said()
        if reached is None and now - began >= earliest and is_reached():
            reached = now
        if reached is not None and now - reached >= seconds:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            assert folder.snakemake("--unlock").status == 0
            return True
        time.sleep(0.01)
    assert process.returncode == 0, folder.said()
    return False


def check_same(folder, other):
    """Assert that two campaigns made the same files with the same bytes."""
    ours, theirs = folder.made, other.made
    assert ours.keys() == theirs.keys()
    assert [name for name in ours if ours[name] != theirs[name]] == []


@pytest.fixture(scope="module")
def alone(growing_folder):
    """A campaign that was left alone."""
    folder = growing_folder(CASES)
    finish(folder)
    assert len(list(folder.path.glob("results/tiny/*/model.inp"))) == 3
    return folder


@pytest.mark.slow
def test_killed_at_random_moments_it_goes_on_to_the_same_bytes(alone, growing_folder):
    killed = growing_folder(CASES)
    draw = random.Random(13)
    jobs, hit = ended_jobs(alone), []
    for turn in range(KILLS):
        # one in each twentieth of the jobs, and so in all increments; a job takes some two seconds
        is_reached = partial(has_ended, killed, int((turn + draw.random()) * jobs / KILLS))
        while not kill_after(killed, is_reached, draw.uniform(0, 3), STARTS_IN):
            check_same(killed, alone)
            shutil.rmtree(killed.path / "results")
        hit.append(len(list(killed.path.glob("results/logs/tiny/00?"))))
    assert set(hit) >= {1, 2, 3}
    finish(killed)
    check_same(killed, alone)


@pytest.mark.slow
def test_killed_while_the_last_step_is_corrected_it_goes_on_to_the_same_bytes(alone, tmp_path):
    killed = type(alone)(shutil.copytree(alone.path, tmp_path / "campaign"))
    results = killed.path / "results"
    made = [results / "tiny/001" / name for name in ("grown.vtp", "growth.json", "base.vtp", "step.csv")]
    log, costs = results / "logs/tiny/001/growth.log", results / "benchmarks/tiny/001/growth.tsv"
    with open(costs, newline="") as stream:
        seconds = float(next(csv.DictReader(stream, delimiter="\t"))["s"])
    shutil.rmtree(results / "tiny/002")
    hit = 0
    for turn in range(AIMED_KILLS):
        for path in (*made, log):
            path.unlink(missing_ok=True)
        # the job's shell makes its log first
        assert kill_after(killed, log.exists, seconds * turn / AIMED_KILLS)
        hit += not made[0].exists()
    assert hit >= 2  # the later ones may come too late where the first run was slower
    finish(killed)
    check_same(killed, alone)
