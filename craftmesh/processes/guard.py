"""A guard process between a program and its owner; if either ends, all children of the program end too.

`python -m craftmesh.processes.guard WORDS` runs a program while the standard input of the guard is open.
However the owner ends, the system closes this input. The guard then kills the program's children and
interrupts the program, as Ctrl-C would.
"""

import os
import select
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import IO

from craftmesh.extras import extra
from craftmesh.processes.job import die_with_parent, inherit_orphans

with extra("workflow"):
    import psutil

STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def guarded(words: Sequence[str], said: IO[str]) -> subprocess.Popen:
    """Start a program under a guard and return the guard's process; `release` ends both.

    words: the program's command line; said: file for its standard output and errors.
    """
    command = [sys.executable, "-P", "-m", "craftmesh.processes.guard", *words]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=said, stderr=subprocess.STDOUT)


def release(child: subprocess.Popen) -> None:
    """End a guarded program, kill its children, and wait for the program."""
    if child.stdin:
        child.stdin.close()
    child.wait()


def main() -> int:
    """Run the program in this command's arguments, and return its status, 128 + n if signal n ended it."""
    inherit_orphans()
    program = subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL, preexec_fn=_prepare)
    for number in STOPPING:
        signal.signal(number, signal.SIG_IGN)  # the owner handles these signals
    end = os.pidfd_open(program.pid)
    if end not in select.select([0, end], [], [])[0]:
        program.send_signal(signal.SIGSTOP)  # the program starts no more children
        _kill(program.pid)
        program.send_signal(signal.SIGINT)
        program.send_signal(signal.SIGCONT)
    status = program.wait()
    _kill()
    return status if status >= 0 else 128 - status


def _prepare() -> None:
    """Restore Ctrl-C for the program, because shells disable it for background jobs.

    The program also gets an interrupt when the guard ends.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    die_with_parent(signal.SIGINT)


def _kill(spared: int = 0) -> None:
    """Kill all descendants of this process except the process with the id `spared`."""
    for one in psutil.Process().children(recursive=True):
        if one.pid != spared:
            with suppress(psutil.NoSuchProcess):
                one.kill()


if __name__ == "__main__":
    sys.exit(main())
