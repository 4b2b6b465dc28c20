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
_LAST_LINES = 3
_LIBC = ctypes.CDLL(None)


@dataclass(frozen=True)
class Limits:
    """What one task may use: `time` in seconds of the clock, `memory` in gigabytes of address space."""

    time: float
    memory: float


@dataclass(frozen=True)
class Job:
    """`function(shared, task)` for many tasks, each under the limits.

    Tasks and results are pickled. `warm_up(shared)` is called once before there are workers: they share
    what it loads, and time limits do not count compilation.
    """

    function: Callable[[Any, Any], Any]
    shared: Any
    limits: Limits
    warm_up: Callable[[Any], None] | None = None


class Failure(NamedTuple):
    """Why a task has no result, and where: rows of what the task is about, if its error names them.

    `is_system`: the machine is at fault (a full disk, say), so that other attempts are in vain.
    """

    reason: str
    where: Any = ()
    is_system: bool = False


def run_program(words: Sequence[str], folder: Path, limits: Limits, log: Path) -> str:
    """Run a program in `folder` and return what it printed, which goes to the file `log` too.

    It and all that it starts end at the limit of time; it ends with us, however we end. Raises
    CraftmeshError for a program that is not there, passes its limits or ends with a status that is not 0,
    with the last lines it printed.
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
                f"{words[0]}: cannot be run ({error.strerror}); install it, or name it in full by `command`"
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
    """Bind the program to its limit of memory and to the life of its parent."""
    die_with_parent(signal.SIGKILL)
    limit_memory(limits.memory)


def die_with_parent(number: int) -> None:
    """Let this process get a signal where its parent ends, however that ends."""
    _LIBC.prctl(1, number)  # PR_SET_PDEATHSIG of prctl(2)


def inherit_orphans() -> None:
    """Let this process be the parent of what its children leave running."""
    _LIBC.prctl(36, 1)  # PR_SET_CHILD_SUBREAPER


def limit_memory(gigabytes: float) -> None:
    """Limit the address space of this process."""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = int(gigabytes * GIGABYTE)
    resource.setrlimit(resource.RLIMIT_AS, (limit if hard < 0 else min(limit, hard), hard))
