"""Time and memory of a subcommand, in the columns of Snakemake's benchmark files."""

import os
import time
from datetime import timedelta
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage

from craftmesh.atomic import atomic_path

VARIABLE = "CRAFTMESH_COSTS"  # environment variable: path of the file for a job's costs
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
    """Write the time and memory of this process and of its ended children to the file `path`.

    began: start of the process by `time.monotonic`. Memory in MB is the peak of the largest single process.
    Columns that the system does not report get NA.
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
    """Return the path of the file for this process's costs, "" if none is asked for.

    The environment variable is removed, so that programs that this process starts write no costs.
    """
    return os.environ.pop(VARIABLE, "")
