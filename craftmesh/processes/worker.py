"""Tasks on worker processes; a worker may hang, run out of memory or crash without harm to others."""

import errno
import gc
import heapq
import os
import pickle
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from tempfile import gettempdir
from typing import Any, NoReturn, Protocol

from craftmesh.errors import CraftmeshError
from craftmesh.processes.job import GIGABYTE, Failure, Job, limit_memory

DISK_FAULTS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)  # full disk, quota, size, read-only


class Worker:
    """A process that does a job for one task at a time.

    The process is a fork, so it has modules, kernels and shared data from the start. It may add
    `job.limits.memory` gigabytes to its address space. Its output is dropped. It has its own working
    folder for files that programs leave; the folder is removed with the worker.
    """

    def __init__(self, job: Job):
        self.job = job
        self.key: Any = None
        self.deadline = 0.0
        self.status: int | None = None
        self.folder = tempfile.TemporaryDirectory(prefix="craftmesh-")
        self.connection, child = Pipe()
        self.pid = os.fork()
        if not self.pid:
            _serve(child, self.folder.name, job)
        child.close()

    def start(self, key: Any, task: Any) -> None:
        """Send a task to the process and start its time limit; key: identifies the task."""
        self.key = key
        self.deadline = time.monotonic() + self.job.limits.time
        with suppress(OSError):  # the process is dead; `receive` will report it
            self.connection.send(task)

    def finish(self) -> tuple[Any, float]:
        """Mark the worker as free, and return the key of its task and the seconds that the task took."""
        key, self.key = self.key, None
        return key, time.monotonic() - (self.deadline - self.job.limits.time)

    def receive(self) -> tuple[str, Any]:
        """Wait for an answer: ("done", result), ("failed", Failure), or ("died", Failure) if it ended."""
        try:
            kind, value = self.connection.recv()
        except (EOFError, OSError, pickle.UnpicklingError):
            status = self.wait()
            return "died", Failure(
                f"ended by signal {-status}" if status < 0 else f"ended with status {status}"
            )
        return kind, value

    def wait(self) -> int:
        """Wait for the process and return its exit status, negative for a signal."""
        if self.status is None:
            self.status = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        return self.status

    def kill(self) -> None:
        """Kill the process and the programs that it runs, and remove its working folder."""
        if self.status is None:
            os.kill(self.pid, signal.SIGKILL)
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        self.wait()
        self.connection.close()
        self.folder.cleanup()


def _serve(connection: Connection, folder: str, job: Job) -> NoReturn:
    """Run tasks from the connection in a forked process until the connection closes; end the process."""
    status = 1
    try:
        gc.freeze()
        os.setsid()
        nowhere, own = os.open(os.devnull, os.O_RDWR), connection.fileno()
        for file in range(3):
            os.dup2(nowhere, file)
        os.closerange(3, own)
        os.closerange(own + 1, os.sysconf("SC_OPEN_MAX"))
        sys.path[:] = map(os.path.abspath, sys.path)
        os.chdir(folder)
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit_memory(pages * os.sysconf("SC_PAGE_SIZE") / GIGABYTE + job.limits.memory)
        while True:
            connection.send(_answer(job, connection.recv()))
    except EOFError:
        status = 0
    finally:
        os._exit(status)


def _answer(job: Job, task: Any) -> tuple[str, Any]:
    """Return ("done", result) or ("failed", Failure) of a task."""
    try:
        return "done", job.function(job.shared, task)
    except MemoryError:
        return "failed", Failure(f"needs more memory than {job.limits.memory:g} GB")
    except OSError as error:
        reason = error.strerror or str(error)
        return "failed", Failure(reason, is_system=error.errno in DISK_FAULTS)
    except Exception as error:
        return "failed", Failure(str(error) or type(error).__name__, getattr(error, "where", ()))


class Listener(Protocol):
    """Receiver of results and failures of tasks."""

    def on_done(self, task: Any, value: Any, seconds: float, /) -> None:
        """Receive the result of a task."""

    def on_failure(self, task: Any, failure: Failure, seconds: float, /) -> Any | None:
        """Receive a task's failure; return a task to try instead, or None to give up."""


def run_tasks(job: Job, tasks: Sequence[tuple[float, Any]], listener: Listener, workers: int) -> None:
    """Run the job for all (cost, task), in order of falling cost.

    A worker takes the next task when its last task ends, which balances the load. A task that raises an
    error, crashes its process or exceeds the time limit goes to `listener.on_failure`. A process that
    crashed or took too long is replaced; other tasks continue. Raises CraftmeshError if a worker cannot
    write files, as on a full disk.
    """
    if tasks and job.warm_up:
        job.warm_up(job.shared)
    pool = _Pool(job, tasks, listener)
    try:
        pool.run(min(max(workers, 1), len(tasks)))
    finally:
        for worker in pool.staff:
            worker.kill()


class _Pool:
    """The workers, and a queue of waiting tasks."""

    def __init__(self, job: Job, tasks: Sequence[tuple[float, Any]], listener: Listener):
        self.job, self.listener = job, listener
        self.current = [task for _, task in tasks]
        # highest cost first; equal costs in the order of the tasks
        self.queue = [(-cost, order) for order, (cost, _) in enumerate(tasks)]
        heapq.heapify(self.queue)
        self.staff: list[Worker] = []

    def run(self, workers: int) -> None:
        """Run all tasks on this number of workers, and return when all have ended."""
        for _ in range(workers):
            self.staff.append(Worker(self.job))
        while self.queue or any(worker.key for worker in self.staff):
            for worker in self.staff:  # free workers take the costliest tasks
                if worker.key is None and self.queue:
                    key = heapq.heappop(self.queue)
                    worker.start(key, self.current[key[1]])
            for index, kind, value in self._hear():
                self._take(index, kind, value)

    def _hear(self) -> list[tuple[int, str, Any]]:
        """Wait for an answer or a timeout, and return (worker's index, kind, value) of each.

        kind and value are those of `Worker.receive`; a timeout counts as "died".
        """
        busy = [(index, worker) for index, worker in enumerate(self.staff) if worker.key]
        timeout = min(worker.deadline for _, worker in busy) - time.monotonic()
        spoken = wait([worker.connection for _, worker in busy], max(0.0, timeout))
        heard: list[tuple[int, str, Any]] = []
        for index, worker in busy:
            if worker.connection in spoken:
                heard.append((index, *worker.receive()))
            elif worker.deadline <= time.monotonic():
                limit = self.job.limits.time
                heard.append((index, "died", Failure(f"gave no answer within {limit:g} s")))
        return heard

    def _take(self, index: int, kind: str, value: Any) -> None:
        """Handle a worker's answer, and replace the worker if it died."""
        worker = self.staff[index]
        self._settle(worker, kind, value)
        if kind == "died":
            worker.kill()
            self.staff[index] = Worker(self.job)

    def _settle(self, worker: Worker, kind: str, value: Any) -> None:
        """Report the end of the worker's task to the listener; queue the task that it returns, if any."""
        key, seconds = worker.finish()
        order = key[1]
        if kind == "done":
            self.listener.on_done(self.current[order], value, seconds)
            return
        if value.is_system:
            raise CraftmeshError(
                f"a worker process cannot write its files ({value.reason}); free space in the temporary "
                f"folder {gettempdir()}"
            )
        again = self.listener.on_failure(self.current[order], value, seconds)
        if again is not None:
            self.current[order] = again
            heapq.heappush(self.queue, key)
