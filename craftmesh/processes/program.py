"""One call of a program under limits, its output in a file."""

import ctypes
import os
import signal
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from craftmesh.errors import CraftmeshError
from craftmesh.processes.job import Limits
from craftmesh.processes.worker import limit_memory

_LAST_LINES = 3
_LIBC = ctypes.CDLL(None)
_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)


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
    _LIBC.prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    limit_memory(limits.memory)
