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
from typing import Any, NamedTuple

from craftmesh.errors import CraftmeshError

START_LIMIT = 300.0
GIGABYTE = 2**30
DISK_FAULTS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)
_START = "import sys; from craftmesh.processes.worker import serve; serve(int(sys.argv[1]))"


class Failure(NamedTuple):
    """Why a task has no result, and where: rows of what the task is about, if its error names them.

    `is_system`: the machine is at fault (a full disk, say), so that other attempts are in vain.
    """

    reason: str
    where: Any = ()
    is_system: bool = False


class Worker:
    """A process that calls `function(shared, task)` for one task at a time.

    `function` is a module's function; all that passes is pickled. The process has its own address space
    of at most `memory_limit` gigabytes, nowhere to print to and a working folder of its own, which is
    removed with it (meshers leave files behind). `warm_up(shared)` is called once before
    the first clock runs, so that time limits do not count compilation.
    """

    def __init__(self, function, shared: Any, memory_limit: float, warm_up=None):
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
        self._send((function, shared, memory_limit, warm_up))

    def start(self, key: Any, task: Any, time_limit: float) -> None:
        """Hand over the task known by `key`; its clock starts now."""
        self.key = key
        self.deadline = time.monotonic() + time_limit
        self._send(task)

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
                f"worker processes cannot receive the sizing or options ({error})"
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
        function, shared, memory_limit, warm_up = connection.recv()
        if warm_up is not None:
            warm_up(shared)
        _limit_memory(memory_limit)
    except Exception as error:
        connection.send(("failed", Failure(f"cannot start: {type(error).__name__}: {error}")))
        return
    connection.send(("ready", None))
    while True:
        try:
            task = connection.recv()
        except EOFError:
            return
        try:
            answer = "done", function(shared, task)
        except MemoryError:
            answer = "failed", Failure(f"needs more memory than {memory_limit:g} GB")
        except OSError as error:
            reason = error.strerror or str(error)
            answer = "failed", Failure(reason, is_system=error.errno in DISK_FAULTS)
        except Exception as error:
            answer = "failed", Failure(str(error) or type(error).__name__, getattr(error, "where", ()))
        connection.send(answer)


def _limit_memory(gigabytes: float) -> None:
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = int(gigabytes * GIGABYTE)
    resource.setrlimit(resource.RLIMIT_AS, (limit if hard < 0 else min(limit, hard), hard))
