"""What a verb took, in the columns of Snakemake's benchmark files."""

import os
import time
from datetime import timedelta
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage

from craftmesh.atomic import atomic_path

VARIABLE = "CRAFTMESH_COSTS"  # names the file in which a job keeps its costs
COLUMNS = (
    "s",
    "h:m:s",
    "max_rss",
    "max_vms",
    "max_uss",
    "max_pss",
    "io_in",
    "io_out",
    "mean_load",
    "cpu_time",
)


def write_costs(path: str, began: float) -> None:
    """Write the costs of this process and of its children that have ended.

    began: the process's start by `time.monotonic`. Memory is the largest of any of the processes, in MB.
    Columns that the system does not tell have NA.
    """
    seconds = time.monotonic() - began
    used = getrusage(RUSAGE_SELF), getrusage(RUSAGE_CHILDREN)
    cpu = sum(one.ru_utime + one.ru_stime for one in used)
    row = dict.fromkeys(COLUMNS, "NA")
    row |= {"s": f"{seconds:.4f}", "h:m:s": str(timedelta(seconds=int(seconds))), "cpu_time": f"{cpu:.2f}"}
    row |= {
        "mean_load": f"{100 * cpu / seconds:.2f}",
        "max_rss": f"{max(u.ru_maxrss for u in used) / 1024:.2f}",
    }
    with atomic_path(Path(path)) as temporary:
        temporary.write_text(
            "".join("\t".join(line) + "\n" for line in (row, row.values())), encoding="utf-8"
        )


def asked_costs() -> str:
    """Return the file for this process's costs, empty without one; programs that it starts have none."""
    return os.environ.pop(VARIABLE, "")
