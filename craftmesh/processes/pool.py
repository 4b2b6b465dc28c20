"""Tasks on worker processes: largest first, each under limits, failures handed back one by one."""

import heapq
import time
from collections.abc import Callable
from multiprocessing.connection import wait
from tempfile import gettempdir
from typing import Any

from craftmesh.errors import CraftmeshError
from craftmesh.processes.worker import Failure, Worker


def run_tasks(
    function: Callable[[Any, Any], Any],
    shared: Any,
    tasks: list[tuple[float, Any]],
    on_done: Callable[[Any, Any, float], None],
    on_failure: Callable[[Any, Failure, float], Any | None],
    workers: int,
    time_limit: float,
    memory_limit: float,
    warm_up: Callable[[Any], None] | None = None,
) -> None:
    """Run `function(shared, task)` for all (cost, task), the costly ones first.

    A worker takes its next task when it is done with the last, which balances the load. A task that
    raises, crashes its process or passes `time_limit` seconds goes to `on_failure(task, failure, seconds)`,
    which may return a task to try instead; the process is replaced and all others go on. Raises
    CraftmeshError where the system refuses a worker its files.
    """
    # the costliest first; among equals the first one
    queue = [(-cost, order) for order, (cost, _) in enumerate(tasks)]
    heapq.heapify(queue)
    current = [task for _, task in tasks]

    def settle(worker: Worker, kind: str, value: Any) -> None:
        key, worker.key = worker.key, None
        seconds = time.monotonic() - (worker.deadline - time_limit)
        task = current[key[1]]
        if kind == "done":
            on_done(task, value, seconds)
            return
        if value.is_system:
            raise CraftmeshError(
                f"a worker process was refused by the system ({value.reason}); check the space of the "
                f"temporary folder {gettempdir()}"
            )
        again = on_failure(task, value, seconds)
        if again is not None:
            current[key[1]] = again
            heapq.heappush(queue, key)

    staff = [
        Worker(function, shared, memory_limit, warm_up) for _ in range(min(max(workers, 1), len(tasks)))
    ]
    try:
        while queue or any(worker.key for worker in staff):
            for worker in staff:
                if worker.is_ready and worker.key is None and queue:
                    key = heapq.heappop(queue)
                    worker.start(key, current[key[1]], time_limit)
            for index, (kind, value) in _hear(staff, time_limit):
                worker = staff[index]
                if kind == "ready":
                    continue
                if worker.key is None:
                    raise CraftmeshError(
                        f"a worker process {value.reason}; check memory_limit and the installation"
                    )
                settle(worker, kind, value)
                if kind == "died":
                    worker.kill()
                    staff[index] = Worker(function, shared, memory_limit, warm_up)
    finally:
        for worker in staff:
            worker.kill()


def _hear(staff: list[Worker], time_limit: float) -> list[tuple[int, tuple[str, Any]]]:
    """Wait until a worker speaks or runs out of time; return (index, (kind, value)) of those workers."""
    busy = [(index, worker) for index, worker in enumerate(staff) if worker.key or not worker.is_ready]
    timeout = min(worker.deadline for _, worker in busy) - time.monotonic()
    spoken = wait([worker.connection for _, worker in busy], max(0.0, timeout))
    heard = []
    for index, worker in busy:
        if worker.connection in spoken:
            heard.append((index, worker.receive()))
        elif worker.deadline <= time.monotonic():
            heard.append((index, ("died", Failure(f"gave no answer within {time_limit:g} s"))))
    return heard
