"""Locks of dead runs are removed with a note; those of living runs, and of runs elsewhere, stay."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from craftmesh.campaign.runs import LOCKS, RUNS, enter, run_of
from craftmesh.campaign.workflow_location import refusal
from craftmesh.processes.guard import guarded, release

SLEEP = "import time; time.sleep(60)"
# it starts one more program, in a session of its own
NESTED = (
    "import subprocess, sys, time\n"
    f"child = subprocess.Popen([sys.executable, '-c', {SLEEP!r}], start_new_session=True)\n"
    "open('pids', 'w').write(str(child.pid) + '\\n')\n"
    "time.sleep(60)\n"
)


@pytest.fixture(autouse=True)
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("atexit.register", lambda *_, **__: None)
    LOCKS.mkdir(parents=True)
    RUNS.mkdir(parents=True)
    (LOCKS / "0.output.lock").write_text("results/a/labels.npz\n")


def leave(**changed) -> None:
    """Leave the file of another run: of this process's parent, which lives, but for what is changed."""
    run = run_of(os.getppid())._replace(**changed)
    (RUNS / f"other-{len(list(RUNS.iterdir()))}.json").write_text(json.dumps(run))


DEAD = {"start": "1"}  # a process of that number, but of another start
REBOOTED = {"boot": "another"}
ELSEWHERE = {"host": "node7"}


@pytest.mark.parametrize(
    ("runs", "is_removed", "words"),
    [
        ([DEAD], True, ["removed the lock that a killed run left", f"pid {os.getppid()}"]),
        ([REBOOTED], True, ["removed the lock"]),
        ([DEAD, DEAD], True, ["removed the lock"]),
        ([{"pid": 2**22 + 1}], True, ["removed the lock"]),
        (
            [{}],
            False,
            ["is locked by another run, pid", os.uname().nodename, "wait for its end, or kill it"],
        ),
        ([DEAD, {}], False, ["is locked by another run"]),
        ([ELSEWHERE], False, ["is locked by another run", "on node7", "snakemake --unlock"]),
        ([DEAD, ELSEWHERE], False, ["on node7", "snakemake --unlock"]),
        ([], False, ["is locked by an unknown run", "snakemake --unlock"]),
    ],
)
def test_a_lock_goes_where_all_other_runs_are_dead(runs, is_removed, words):
    for changed in runs:
        leave(**changed)
    note = enter()
    assert all(word in note for word in words) and "\n" not in note
    assert LOCKS.exists() != is_removed
    left = [changed for changed in runs if not changed or changed == ELSEWHERE]
    assert len(list(RUNS.glob("other-*.json"))) == len(left)
    said = f"craftmesh: note: {note}\nError: Directory cannot be locked. Please\nmore\n"
    assert (refusal(said) == note) == (not is_removed)


def test_without_a_lock_nothing_is_told():
    (LOCKS / "0.output.lock").unlink()
    leave()
    leave(**DEAD)
    assert enter() == ""
    assert len(list(RUNS.iterdir())) == 2  # the living one and this


def is_running(pid: int) -> bool:
    found = run_of(pid)
    return found is not None


def wait_for(reached) -> bool:
    until = time.monotonic() + 60
    while not reached() and time.monotonic() < until:
        time.sleep(0.05)
    return bool(reached())


def pids() -> list[int]:
    file = Path("pids")
    return [int(word) for word in file.read_text().split()] if file.is_file() else []


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGKILL])
def test_whatever_ends_an_owner_ends_all_that_its_program_runs(number):
    owner = (
        "import sys, time; from craftmesh.processes.guard import guarded\n"
        f"child = guarded([sys.executable, '-c', {NESTED!r}], open('said', 'w'))\n"
        "print(child.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", owner], stdout=subprocess.PIPE, text=True)
    guard = int(process.stdout.readline())
    assert wait_for(pids)
    process.send_signal(number)
    process.wait()
    assert wait_for(lambda: not any(map(is_running, [guard, *pids()])))


def test_a_program_that_ends_leaves_nothing_but_its_status():
    program = f"{NESTED.rpartition('time.sleep')[0]}sys.exit(3)\n"
    with open("said", "w") as said:
        child = guarded([sys.executable, "-c", program], said)
        assert child.wait() == 3
        release(child)
    assert wait_for(lambda: not is_running(pids()[0]))  # killed processes take a moment to end


def test_a_released_program_is_interrupted_as_by_hand():
    program = (
        "import time\ntry:\n    print('begun', flush=True)\n    time.sleep(60)\n"
        "except KeyboardInterrupt:\n    print('cleaned')\n"
    )
    with open("said", "w") as said:
        child = guarded([sys.executable, "-c", program], said)
        assert wait_for(lambda: "begun" in Path("said").read_text())
        release(child)
    assert "cleaned" in Path("said").read_text()
