"""Tasks run under limits: what they do to their process harms no other task, and all of it is told."""

import mmap
import os
import signal
import time
from contextlib import suppress

import psutil
import pytest

from craftmesh.errors import CraftmeshError
from craftmesh.processes.job import Job, Limits
from craftmesh.processes.worker import run_tasks

LIMITS = Limits(time=60.0, memory=4.0)


def work(shared, task):
    """Do what the task's name says; called in a worker."""
    if task == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if task == "hang":
        time.sleep(600)
    if task == "raise":
        raise ValueError("no good")
    if task == "eat":
        return len(bytearray(8 * 2**30))
    if task == "full disk":
        raise OSError(28, "No space left on device")
    open("left behind", "w").close()
    return shared, task, os.getcwd()


class Ledger:
    """A Listener that writes down what it hears and offers `instead` of a task that failed."""

    def __init__(self, instead=None):
        self.results, self.reasons, self.instead = {}, {}, dict(instead or {})

    def on_done(self, task, value, seconds):
        assert seconds >= 0
        self.results[task] = value

    def on_failure(self, task, failure, seconds):
        assert seconds >= 0
        self.reasons[task] = failure.reason
        return self.instead.pop(task, None)


def run(tasks, limits=LIMITS, workers=1, **ledger):
    heard = Ledger(**ledger)
    run_tasks(Job(work, "shared", limits), tasks, heard, workers)
    return heard


def test_the_costliest_come_first_and_equals_in_their_order():
    heard = run([(1.0, "d"), (2.0, "b"), (3.0, "a"), (2.0, "c")])
    assert list(heard.results) == ["a", "b", "c", "d"] and heard.reasons == {}
    assert all(value[:2] == ("shared", task) for task, value in heard.results.items())


def test_a_task_that_ends_its_process_ends_no_other():
    tasks = [(3.0, "crash"), (2.0, "raise"), (1.0, "last"), (4.0, "first")]
    heard = run(tasks, workers=2)
    assert heard.reasons == {"crash": f"ended by signal {signal.SIGSEGV.value}", "raise": "no good"}
    assert set(heard.results) == {"first", "last"}


def test_limits_of_time_and_memory_are_told_apart():
    assert run([(1.0, "hang")], Limits(0.3, 4.0)).reasons == {"hang": "gave no answer within 0.3 s"}
    assert run([(1.0, "eat")]).reasons == {"eat": "needs more memory than 4 GB"}


def test_a_failed_task_may_be_tried_in_another_way():
    heard = run([(1.0, "raise")], instead={"raise": "simpler"})
    assert list(heard.reasons) == ["raise"] and list(heard.results) == ["simpler"]


def test_each_worker_has_a_folder_that_goes_with_it():
    (_, _, folder) = run([(1.0, "a")]).results["a"]
    assert os.path.realpath(folder) != os.path.realpath(os.getcwd()) and not os.path.exists(folder)


def test_no_tasks_need_no_workers():
    heard = run([], workers=4)
    assert heard.results == heard.reasons == {}


def test_faults_of_the_system_end_the_work_with_one_line():
    with pytest.raises(CraftmeshError, match="No space left on device.*temporary folder"):
        run([(1.0, "full disk")])


def test_workers_have_what_was_loaded_before_them_once():
    loaded, heard = [], Ledger()
    job = Job(lambda shared, _: (shared(), os.getpid()), lambda: len(loaded), LIMITS, loaded.append)
    run_tasks(job, [(1.0, "a"), (1.0, "b")], heard, 2)
    assert [count for count, _ in heard.results.values()] == [1, 1] and len(loaded) == 1
    assert os.getpid() not in {pid for _, pid in heard.results.values()}


def test_memory_of_the_process_itself_is_none_of_its_workers():
    held = mmap.mmap(-1, 3 * 2**30)  # address space alone
    assert list(run([(1.0, "a")], Limits(60.0, 1.0)).results) == ["a"]
    held.close()


def test_workers_keep_no_file_of_their_owner_open():
    mine, other = os.pipe()
    heard = Ledger()

    def closed(_, task):
        os.close(other)
        return task

    run_tasks(Job(closed, None, LIMITS), [(1.0, "a")], heard, 1)
    os.close(mine), os.close(other)
    assert heard.reasons == {"a": "Bad file descriptor"}


def is_gone(pid: int) -> bool:
    with suppress(psutil.NoSuchProcess):
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    return True


def wait_for(is_reached, seconds: float = 60):
    until = time.monotonic() + seconds
    while not is_reached():
        assert time.monotonic() < until
        time.sleep(0.02)


def test_workers_end_with_their_owner(tmp_path):
    def say(_, task):
        (tmp_path / task).write_text(str(os.getpid()))
        time.sleep(1)

    owner = os.fork()
    if not owner:
        run_tasks(Job(say, None, LIMITS), [(2.0, "first"), (1.0, "second")], Ledger(), 2)
        os._exit(0)
    wait_for(lambda: len([path for path in tmp_path.iterdir() if path.read_text()]) == 2)
    os.kill(owner, signal.SIGKILL)
    os.waitpid(owner, 0)
    wait_for(lambda: all(is_gone(int(path.read_text())) for path in tmp_path.iterdir()))
