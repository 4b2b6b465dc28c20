"""A worker process that can hang, run out of memory or crash without harm to anyone else."""

import errno
import os
import pickle
import resource
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

from craftmesh.errors import CraftmeshError
from craftmesh.processes.job import Failure, Job

# Seconds for a process to start, imports and warm-up included: the first run compiles all kernels.
START_LIMIT = 300.0
GIGABYTE = 2**30
DISK_FAULTS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)
_START = "import sys; from craftmesh.processes.worker import serve; serve(int(sys.argv[1]))"


class Worker:
    """A process that does a job for one task at a time.

    The process has its own address space of at most `job.limits.memory` gigabytes, nowhere to print to and
    a working folder of its own, which is removed with it (programs leave files behind). Raises
    CraftmeshError where the job cannot be pickled.
    """

    def __init__(self, job: Job):
        self.job = job
        self.key: Any = None
        self.is_ready = False
        self.deadline = time.monotonic() + START_LIMIT
        self.connection, child = Pipe()
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(os.path.abspath(path) for path in sys.path),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "NUMBA_NUM_THREADS": "1",
        }
        self.folder = tempfile.TemporaryDirectory(prefix="craftmesh-")
        self.process = subprocess.Popen(
            [sys.executable, "-c", _START, str(child.fileno())],
            pass_fds=[child.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment,
            cwd=self.folder.name,
            start_new_session=True,
        )
        child.close()
        self._send(job)

    @property
    def is_busy(self) -> bool:
        """Whether it starts up or has a task."""
        return self.key is not None or not self.is_ready

    def start(self, key: Any, task: Any) -> None:
        """Hand over the task known by `key`; its clock starts now."""
        self.key = key
        self.deadline = time.monotonic() + self.job.limits.time
        self._send(task)

    def finish(self) -> tuple[Any, float]:
        """Return the key of the task, which is no longer the worker's, and the seconds it took."""
        key, self.key = self.key, None
        return key, time.monotonic() - (self.deadline - self.job.limits.time)

    def receive(self) -> tuple[str, Any]:
        """Return what the process has to say: ("ready" | "done" | "failed" | "died", value)."""
        try:
            kind, value = self.connection.recv()
        except (EOFError, OSError, pickle.UnpicklingError):
            return "died", Failure(self._last_words())
        self.is_ready = True
        return kind, value

    def kill(self) -> None:
        """End the process and the programs that it runs at once."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self.connection.close()
        self.folder.cleanup()

    def _send(self, message: Any) -> None:
        try:
            payload = pickle.dumps(message)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            self.kill()
            raise CraftmeshError(
                f"worker processes cannot receive {self.job.shared_name} ({error}); take classes and "
                "functions of a module"
            ) from error
        try:
            self.connection.send_bytes(payload)
        except OSError:
            # the process is dead: the broken connection says so when it is read
            return

    def _last_words(self) -> str:
        status = self.process.wait()
        return f"ended by signal {-status}" if status < 0 else f"ended with status {status}"


def serve(descriptor: int) -> None:
    """Run tasks that come through the pipe `descriptor` until it closes."""
    connection = Connection(descriptor)
    try:
        job = connection.recv()
        if job.warm_up is not None:
            job.warm_up(job.shared)
        limit_memory(job.limits.memory)
    except Exception as error:
        connection.send(("failed", Failure(f"cannot start: {type(error).__name__}: {error}")))
        return
    connection.send(("ready", None))
    while True:
        try:
            task = connection.recv()
        except EOFError:
            return
        connection.send(_answer(job, task))


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


def limit_memory(gigabytes: float) -> None:
    """Limit the address space of this process."""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = int(gigabytes * GIGABYTE)
    resource.setrlimit(resource.RLIMIT_AS, (limit if hard < 0 else min(limit, hard), hard))
