"""A process between a program and who started it: where either ends, all that the program runs ends too.

`python -m craftmesh.processes.guard WORDS` runs a program while the standard input of the guard is open.
The system closes it however the guard's owner ends. Then what the program runs is killed, and the program
itself is interrupted, as by Ctrl-C.
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
    """Start a program under a guard; what it says goes to the file `said`, and `release` ends it."""
    command = [sys.executable, "-P", "-m", "craftmesh.processes.guard", *words]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=said, stderr=subprocess.STDOUT)


def release(child: subprocess.Popen) -> None:
    """End a guarded program, kill all that it runs, and wait for the program."""
    if child.stdin:
        child.stdin.close()
    child.wait()


def main() -> int:
    inherit_orphans()
    program = subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL, preexec_fn=_prepare)
    for number in STOPPING:
        signal.signal(number, signal.SIG_IGN)  # the owner hears them
    end = os.pidfd_open(program.pid)
    if end not in select.select([0, end], [], [])[0]:
        program.send_signal(signal.SIGSTOP)  # it starts nothing more
        _kill(program.pid)
        program.send_signal(signal.SIGINT)
        program.send_signal(signal.SIGCONT)
    status = program.wait()
    _kill()
    return status if status >= 0 else 128 - status


def _prepare() -> None:
    """Let the program hear Ctrl-C, which shells take from what they run in the background."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    die_with_parent(signal.SIGINT)


def _kill(spared: int = 0) -> None:
    """Kill all that this process and its children started, but the process `spared`."""
    for one in psutil.Process().children(recursive=True):
        if one.pid != spared:
            with suppress(psutil.NoSuchProcess):
                one.kill()


if __name__ == "__main__":
    sys.exit(main())
