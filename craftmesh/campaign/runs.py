"""Runs of Snakemake in a folder, and removal of the lock that a killed run left.

Snakemake's lock of a folder does not name its process. So each run writes a file that names its process,
and removes it at its end. If a run is killed, its lock and this file stay.
"""

import atexit
import json
import os
import shutil
from pathlib import Path
from typing import NamedTuple

LOCKS = Path(".snakemake", "locks")
RUNS = Path(".snakemake", "craftmesh", "runs")
_BOOT = Path("/proc/sys/kernel/random/boot_id")


class Run(NamedTuple):
    """A process on a machine.

    host: machine name; boot: id of the machine's boot; pid: process id; start: start time of the process in
    clock ticks since the boot, because ids of processes are used again.
    """

    host: str
    boot: str
    pid: int
    start: str

    @property
    def is_here(self) -> bool:
        return self.host == os.uname().nodename

    @property
    def is_dead(self) -> bool:
        """True if the process has certainly ended; False for a process on another machine."""
        return self.is_here and self != run_of(self.pid)

    def __str__(self) -> str:
        return f"pid {self.pid} on {self.host}"


def run_of(pid: int) -> Run | None:
    """Return the process `pid` of this machine; None if there is none, or only a zombie."""
    try:
        words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        boot = _BOOT.read_text().strip()
    except OSError:
        return None
    return None if words[0] == "Z" else Run(os.uname().nodename, boot, pid, words[19])


def enter() -> str:
    """Write this process's file in the working folder; return a note on locks of other runs, "" without.

    Files of dead runs are removed. If there were other runs and all are dead, their lock is removed too.
    """
    others = {path: Run(*json.loads(path.read_text())) for path in RUNS.glob("*.json")}
    own = RUNS / f"{os.uname().nodename}-{os.getpid()}.json"
    others.pop(own, None)
    try:
        RUNS.mkdir(parents=True, exist_ok=True)
        own.write_text(json.dumps(run_of(os.getpid())))
    except OSError:
        return ""  # Snakemake reports why it cannot write here
    atexit.register(own.unlink, missing_ok=True)
    living = [run for run in others.values() if not run.is_dead]
    for path, run in others.items():
        if run.is_dead:
            path.unlink(missing_ok=True)
    if not LOCKS.is_dir() or not any(LOCKS.iterdir()):
        return ""
    if others and not living:
        shutil.rmtree(LOCKS)
        return f"removed the lock that a killed run left, {', '.join(map(str, others.values()))}"
    return f"the folder is locked by {_holders(living)}"


def _holders(living: list[Run]) -> str:
    if not living:
        return "an unknown run; if none runs on any machine, run `snakemake --unlock` and start again"
    here = all(run.is_here for run in living)
    advice = "wait for its end, or kill it" if here else "if it has ended, run `snakemake --unlock`"
    return f"another run, {', '.join(map(str, living))}; {advice}"
