"""Programs and jobs under limits of time and memory."""

import ctypes
import os
import resource
import signal
import subprocess
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from craftmesh.errors import CraftmeshError

GIGABYTE = 2**30
_LAST_LINES = 3  # number of lines of a program's output that an error has
_LIBC = ctypes.CDLL(None)


@dataclass(frozen=True)
class Limits:
    """Limits of one task: `time` in seconds of wall-clock time, `memory` in GB of address space."""

    time: float
    memory: float


@dataclass(frozen=True)
class Job:
    """A call `function(shared, task)` for many tasks, each under the limits.

    Tasks and results are pickled. `warm_up(shared)` is called once before workers start, so that workers
    share the loaded modules and kernels, and time limits do not include compilation.
    """

    function: Callable[[Any, Any], Any]
    shared: Any
    limits: Limits
    warm_up: Callable[[Any], None] | None = None


class Failure(NamedTuple):
    """The reason why a task has no result.

    where: the attribute `where` of the task's error, for example rows of facets; () if it has none.
    is_system: True if the machine is the cause, for example a full disk, so that retries cannot help.
    """

    reason: str
    where: Any = ()
    is_system: bool = False


def run_program(words: Sequence[str], folder: Path, limits: Limits, log: Path) -> str:
    """Run a program in `folder`, with its output in the file `log`, and return the output.

    The program and its children are killed at the time limit; the program also ends when this process ends.
    It runs with one OpenMP thread unless OMP_NUM_THREADS is set. Raises CraftmeshError if the program
    cannot be started, exceeds its time limit, or ends with a status other than 0; the error then has the
    last lines of output.
    """
    environment = os.environ | {"OMP_NUM_THREADS": os.environ.get("OMP_NUM_THREADS", "1")}
    with open(log, "wb") as stream:
        try:
            process = subprocess.Popen(
                words,
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
                preexec_fn=lambda: _prepare(limits),
            )
        except OSError as error:
            raise CraftmeshError(
                f"{words[0]}: cannot be run ({error.strerror}); install it, or give its path in `command`"
            ) from None
        try:
            status = process.wait(limits.time)
        except subprocess.TimeoutExpired:
            raise CraftmeshError(
                f"{words[0]}: gave no answer within {limits.time:g} s; raise time_limit"
            ) from None
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    text = log.read_text(encoding="utf-8", errors="replace")
    if status:
        said = " | ".join([line.strip() for line in text.splitlines() if line.strip()][-_LAST_LINES:])
        how = f"signal {-status}" if status < 0 else f"status {status}"
        raise CraftmeshError(f"{words[0]}: ended with {how} ({said}); see {log}")
    return text


def _prepare(limits: Limits) -> None:
    """Set the program's memory limit, and let the program end with its parent."""
    die_with_parent(signal.SIGKILL)
    limit_memory(limits.memory)


def die_with_parent(number: int) -> None:
    """Ask the system to send signal `number` to this process when its parent ends."""
    _LIBC.prctl(1, number)  # PR_SET_PDEATHSIG of prctl(2)


def inherit_orphans() -> None:
    """Make this process the new parent of processes that its ended children leave running."""
    _LIBC.prctl(36, 1)  # PR_SET_CHILD_SUBREAPER


def limit_memory(gigabytes: float) -> None:
    """Limit the address space of this process; a lower hard limit of the system stays."""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = int(gigabytes * GIGABYTE)
    resource.setrlimit(resource.RLIMIT_AS, (limit if hard < 0 else min(limit, hard), hard))
