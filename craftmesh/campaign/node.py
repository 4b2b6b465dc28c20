"""A node of the cluster: how many processors and how much memory a job may ask for."""

import os
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from craftmesh.options import Options, option

# Jobs inherit what was found when the campaign was planned, and do not ask the cluster's controller again.
VARIABLE = "CRAFTMESH_NODE"
ANSWERS_WITHIN = 20  # seconds that a busy controller may take
# worker processes of a job of tetrahedra: its grains are few, and the largest one takes as long as the rest
WORKERS = 4


@dataclass(frozen=True)
class NodeOptions(Options):
    """A node of the cluster, in place of the smallest one that Slurm's sinfo names."""

    cpus: int | None = option(
        None, "processors of a node; none: of the smallest that Slurm's sinfo names", at_least=1
    )
    mem_mb: int | None = option(None, "memory of a node; none: likewise", unit="MB", at_least=1)


@dataclass(frozen=True)
class Node:
    """Processors and memory of a node, None where nothing is known, as on a machine without Slurm."""

    cpus: int | None
    mem_mb: int | None

    @property
    def workers(self) -> int:
        """The worker processes of a job of tetrahedra: one on a machine whose jobs share its processors."""
        return 1 if self.cpus is None else min(WORKERS, self.cpus)


def cluster_node(keys: Mapping[str, Any]) -> Node:
    """Return the node that `keys` (cpus, mem_mb) describe, with the cluster's smallest for None."""
    if VARIABLE not in os.environ and None in keys.values():
        os.environ[VARIABLE] = _smallest()
    found = os.environ.get(VARIABLE, "").split()
    cpus, mem_mb = map(int, found) if found else (None, None)
    return Node(keys["cpus"] or cpus, keys["mem_mb"] or mem_mb)


def _smallest() -> str:
    """Return processors and megabytes of the smallest node, in Slurm's default partition if it has one."""
    command = ["sinfo", "--noheader", "--Node", "--format", "%P %c %m"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=ANSWERS_WITHIN)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    rows = [line.split() for line in done.stdout.splitlines() if line.strip()]
    rows = [row for row in rows if row[0].endswith("*")] or rows
    # sinfo writes 64+ where the nodes of a line differ
    sizes = [[int(word.rstrip("+")) for word in row[1:]] for row in rows]
    return " ".join(str(min(column)) for column in zip(*sizes))
