"""Tasks on worker processes: largest first, each under limits, failures handed back one by one."""

import heapq
import time
from collections.abc import Sequence
from multiprocessing.connection import wait
from tempfile import gettempdir
from typing import Any, Protocol

from craftmesh.errors import CraftmeshError
from craftmesh.processes.job import Failure, Job
from craftmesh.processes.worker import Worker


class Listener(Protocol):
    """Who hears what becomes of the tasks."""

    def on_done(self, task: Any, value: Any, seconds: float, /) -> None:
        """Take the result of a task."""

    def on_failure(self, task: Any, failure: Failure, seconds: float, /) -> Any | None:
        """Take a task's failure; return a task to try in its place, or None."""


def run_tasks(job: Job, tasks: Sequence[tuple[float, Any]], listener: Listener, workers: int) -> None:
    """Do the job for all (cost, task), the costly ones first.

    A worker takes its next task when it is done with the last, which balances the load. A task that
    raises, crashes its process or passes the limit of time goes to `listener.on_failure`; the process is
    replaced and all others go on. Raises CraftmeshError where the system refuses a worker its files.
    """
    pool = _Pool(job, tasks, listener)
    try:
        pool.run(min(max(workers, 1), len(tasks)))
    finally:
        pool.close()


class _Pool:
    """Workers and the tasks that wait for them."""

    def __init__(self, job: Job, tasks: Sequence[tuple[float, Any]], listener: Listener):
        self.job, self.listener = job, listener
        self.current = [task for _, task in tasks]
        # the costliest first; among equals the first one
        self.queue = [(-cost, order) for order, (cost, _) in enumerate(tasks)]
        heapq.heapify(self.queue)
        self.staff: list[Worker] = []

    def run(self, workers: int) -> None:
        for _ in range(workers):
            self.staff.append(Worker(self.job))
        while self.queue or any(worker.key for worker in self.staff):
            self._hand_out()
            for index, kind, value in self._hear():
                self._take(index, kind, value)

    def close(self) -> None:
        for worker in self.staff:
            worker.kill()

    def _hand_out(self) -> None:
        """Give idle workers the costliest tasks."""
        for worker in self.staff:
            if worker.is_ready and worker.key is None and self.queue:
                key = heapq.heappop(self.queue)
                worker.start(key, self.current[key[1]])

    def _hear(self) -> list[tuple[int, str, Any]]:
        """Wait until a worker speaks or runs out of time; return (index, kind, value) of those workers."""
        busy = [(index, worker) for index, worker in enumerate(self.staff) if worker.is_busy]
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
        """Take what a worker said, and replace it if it died."""
        worker = self.staff[index]
        if kind == "ready":
            return
        if worker.key is None:
            raise CraftmeshError(
                f"a worker process {value.reason}; check memory_limit and the installation"
            )
        self._settle(worker, kind, value)
        if kind == "died":
            worker.kill()
            self.staff[index] = Worker(self.job)

    def _settle(self, worker: Worker, kind: str, value: Any) -> None:
        """Tell the listener how the worker's task ended; queue what is to be tried in its place."""
        key, seconds = worker.finish()
        order = key[1]
        if kind == "done":
            self.listener.on_done(self.current[order], value, seconds)
            return
        if value.is_system:
            raise CraftmeshError(
                f"a worker process was refused by the system ({value.reason}); check the space of the "
                f"temporary folder {gettempdir()}"
            )
        again = self.listener.on_failure(self.current[order], value, seconds)
        if again is not None:
            self.current[order] = again
            heapq.heappush(self.queue, key)
