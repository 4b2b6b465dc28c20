"""Estimates for the jobs of an increment: elements, CPU time, memory, and what to request of a cluster.

Measured on a virtual machine with two cores (AMD EPYC), kernels compiled; docs/benchmarks.md has the table.
"""

import itertools
import os
import re
import subprocess
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.io.header_checks import HEAD
from craftmesh.options import Options, option
from craftmesh.sizing.sizing import Lengths
from craftmesh.types import Voxels

# Number of tetrahedra over the integral of dV / l^3, with the target length l. Measured on demo, al6xn,
# al1050 and copper with various lengths and cracks: 10.0 to 11.9. Regular tetrahedra, if they filled space,
# would give 8.5.
TETS_PER_CUBE = 11.0
# Facets of the remeshed surface over the voxel faces between labels and on the box: demo 2.3, al1050 2.3,
# al6xn 2.4, copper, whose grains are four voxels across, 3.5.
FACETS_PER_FACE = 2.5
# Number of cells with which the integral begins. Cells wider than COARSE target lengths are split into
# eight, while this makes at most MOST_CELLS cells. For penny cracks with r0 of two voxels and more, the
# result is within 4 % of a sum over three million cells.
CELLS, COARSE, MOST_CELLS = 8_000, 2.0, 300_000
OCTANTS = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))


@dataclass(frozen=True)
class Sizes:
    """Counts on which the costs of an increment's jobs depend; facets: of the remeshed surface."""

    voxels: float
    facets: float
    elements: float


@dataclass(frozen=True)
class Effort:
    """CPU seconds and peak memory in MB of a job."""

    seconds: float
    megabytes: float


@dataclass(frozen=True)
class _Cost:
    """The cost of a job: a fixed part, and microseconds and bytes for each voxel, facet and element."""

    seconds: float
    megabytes: float
    microseconds: tuple[float, float, float] = (0, 0, 0)
    bytes: tuple[float, float, float] = (0, 0, 0)


# Measured costs by rule of the workflow. Python and its libraries take about 1 s and 120 to 250 MB of the
# fixed part. The row of `tetrahedralize` is for one of two jobs that share an increment's tetrahedra, the
# row of `report` for one job for all cases, the row of `renew` for 15 % of the elements renewed.
_COSTS = {
    "generate": _Cost(2, 150, (10, 0, 0), (30, 0, 0)),
    "import_microstructure": _Cost(1.5, 220, (1, 0, 0), (50, 0, 0)),
    "remesh": _Cost(2, 190, (0, 10, 0), (0, 230, 0)),
    "crack": _Cost(1.6, 190, (0, 0, 0), (40, 0, 0)),
    "size": _Cost(1, 125, (0, 0.8, 0), (20, 100, 0)),
    "stitch": _Cost(4.5, 250, (0, 6, 0), (0, 440, 0)),
    "gradate": _Cost(3.2, 300, (0, 14, 1.5), (0, 270, 35)),
    "tetrahedralize": _Cost(3.7, 420, (0, 0, 11), (0, 0, 50)),
    "assemble": _Cost(1.6, 260, (0, 0, 18), (0, 0, 420)),
    "renew": _Cost(8, 420, (0, 3, 10), (0, 440, 420)),
    "inp": _Cost(1.6, 240, (0, 0, 5), (0, 0, 550)),
    "export": _Cost(1.6, 240, (0, 0, 5), (0, 0, 550)),
    "check": _Cost(1.3, 230, (0, 0, 5), (0, 0, 360)),
    "solve": _Cost(2, 250, (0, 0, 95), (0, 0, 2600)),
    "fracture": _Cost(4, 320, (0, 0, 30), (0, 0, 500)),
    "grow": _Cost(2, 170, (0, 0, 0), (250, 0, 0)),
    "depict": _Cost(2.9, 340, (0, 0, 2.7), (0, 0, 260)),
    "report": _Cost(4, 300),
}
# CPU seconds of a job's start, which jobs save that are children of one process with everything loaded: 38
# jobs of a small growing crack took 78 s if each started by itself, and 36 s as such children.
START = 1.0
RULES = tuple(_COSTS)  # in the order of the work


def effort(rule: str, sizes: Sizes, chunks: int = 2, is_warm: bool = False) -> Effort:
    """Return the expected CPU seconds and megabytes of a job of a workflow rule.

    chunks: number of jobs that share an increment's tetrahedra. is_warm: whether stages run in children of
    one process that has everything loaded.
    """
    cost = _COSTS[rule]
    share = 2 / chunks if rule == "tetrahedralize" else 1.0
    counts = (sizes.voxels, sizes.facets, sizes.elements)
    seconds = share * sum(rate * count for rate, count in zip(cost.microseconds, counts)) / 1e6
    megabytes = share * sum(rate * count for rate, count in zip(cost.bytes, counts)) / 1e6
    return Effort(cost.seconds - START * is_warm + seconds, cost.megabytes + megabytes)


def expected_facets(voxels: Voxels) -> float:
    """Return the expected number of facets of the grains' remeshed surface."""
    return FACETS_PER_FACE * voxels.faces


def expected_elements(voxels: Voxels, lengths: Lengths) -> float:
    """Return the expected number of tetrahedra with the target `lengths` in the grains of the volume."""
    extent = voxels.spacing * voxels.labels.shape
    counts = np.maximum(np.round(extent / np.cbrt(extent.prod() / CELLS)), 1)
    cell, total = extent / counts, 0.0
    centres = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    centres = (centres + 0.5) * cell
    while len(centres):
        lengths_there = lengths.at(voxels.origin + centres)
        wide = cell.max() > COARSE * lengths_there
        wide &= len(OCTANTS) * np.count_nonzero(wide) <= MOST_CELLS
        within = voxels.labels[tuple((centres / voxels.spacing).astype(np.int64).T)] > 0
        total += float((lengths_there[within & ~wide] ** -3.0).sum()) * cell.prod()
        cell = cell / 2
        centres = (centres[wide, None] + OCTANTS * cell).reshape(-1, 3)
    return TETS_PER_CUBE * total


# Environment variable with processors and memory of the cluster's smallest node. Jobs inherit it from the
# process that plans the campaign, so that they do not ask the cluster's controller again.
VARIABLE = "CRAFTMESH_NODE"
ANSWERS_WITHIN = 20  # seconds that a busy controller may take
# Largest number of worker processes of a job of tetrahedra: its grains are few, and the largest grain takes
# as long as the others together.
WORKERS = 4


@dataclass(frozen=True)
class NodeOptions(Options):
    """A node of the cluster, used instead of the smallest node in Slurm's sinfo."""

    cpus: int | None = option(
        None, "processors of a node; none: of the smallest that Slurm's sinfo names", at_least=1
    )
    mem_mb: int | None = option(None, "memory of a node; none: likewise", unit="MB", at_least=1)


@dataclass(frozen=True)
class Node:
    """Processors and memory in MB of a node; None if unknown, as on a machine without Slurm."""

    cpus: int | None
    mem_mb: int | None

    @property
    def workers(self) -> int:
        """Number of worker processes of a job of tetrahedra.

        It is 1 if the processors are unknown, because jobs then share this machine's processors.
        """
        return 1 if self.cpus is None else min(WORKERS, self.cpus)


def cluster_node(keys: Mapping[str, Any]) -> Node:
    """Return the node that `keys` (cpus, mem_mb) describe; None becomes the value of the smallest node.

    The smallest node is that of Slurm's sinfo. It is found once and kept in the environment.
    """
    if VARIABLE not in os.environ and None in keys.values():
        os.environ[VARIABLE] = _smallest()
    found = os.environ.get(VARIABLE, "").split()
    cpus, mem_mb = map(int, found) if found else (None, None)
    return Node(keys["cpus"] or cpus, keys["mem_mb"] or mem_mb)


def _smallest() -> str:
    """Return processors and megabytes of the smallest node as text, "" without Slurm.

    Only nodes of Slurm's default partition count, or all nodes if there is none. The two smallest numbers
    may belong to different nodes.
    """
    command = ["sinfo", "--noheader", "--Node", "--format", "%P %c %m"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=ANSWERS_WITHIN)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    rows = [line.split() for line in done.stdout.splitlines() if line.strip()]
    rows = [row for row in rows if row[0].endswith("*")] or rows
    # sinfo writes 64+ if the nodes of a line have different numbers
    sizes = [[int(word.rstrip("+")) for word in row[1:]] for row in rows]
    return " ".join(str(min(column)) for column in zip(*sizes))


# Requested over expected memory, and the same for the stages COUNTED, which know the number of elements
# from a volume.vtu. Expected values hold within a factor of 1.5 on the examples. The number of elements
# that other stages expect from facets is less certain: uniform meshes of examples/paper_2 and paper_3 have
# 17 and 21 per facet.
MEMORY_FACTOR, COUNTED_FACTOR = 2.0, 1.25
COUNTED = ("export", "solve", "fracture", "depict")
# Requested over expected time: nodes are shared, and slower than the machine of the measurements. A job
# that requests an hour does not wait longer in the queue for this.
TIME_FACTOR = 10
COMPILER_MB = 500  # memory to compile the kernels, once on each kind of machine, which takes five minutes
START_MINUTES = 15  # minutes requested in addition
WORKER_MB = 400  # memory of each further worker process of tetrahedralize or renew, on small grains
# Ratio of an attempt's time to that of the attempt before, if not 2: these stages mesh the whole model
# if a grain failed.
LONGER = {"assemble": 5, "renew": 5}
# Number of jobs of one group that run at once on a node: Snakemake requests the sum of their memory.
AT_ONCE = {"inp": 2, "check": 2}
# Tetrahedra over facets of the gradated surface: grains430 9.9, al1050 10.
TETS_PER_FACET = 10.0
_COUNTS = re.compile(rb'NumberOf(Polys|Cells)="(\d+)')


def by_facets(facets: float, voxels: float | None = None) -> Sizes:
    """Return the sizes expected for a number of facets; voxels None counts as the number of facets."""
    return Sizes(facets if voxels is None else voxels, facets, TETS_PER_FACET * facets)


# Sizes assumed for a file that does not exist yet, by suffix: 2e7 voxels, or 1e5 facets. Snakemake may ask
# for a job's memory and time before the file is made; `plan` counts voxels and facets itself.
UNKNOWN = {".npz": by_facets(2e7), ".vtp": by_facets(1e5), ".vtu": by_facets(1e5)}


def memory_mb(stage: str, sizes: Sizes, attempt: int, node: Node) -> int:
    """Return the memory in MB that a stage's job should request, at most its part of the node's memory.

    attempt: number of the attempt, from 1; each further attempt requests twice as much.
    """
    factor = COUNTED_FACTOR if stage in COUNTED else MEMORY_FACTOR
    megabytes = factor * effort(stage, sizes).megabytes + COMPILER_MB
    if stage in ("tetrahedralize", "renew"):
        megabytes += WORKER_MB * (node.workers - 1)
    asked = round(megabytes) * 2 ** (attempt - 1)
    return asked if node.mem_mb is None else min(asked, node.mem_mb // AT_ONCE.get(stage, 1))


def minutes(stage: str, sizes: Sizes, attempt: int) -> int:
    """Return the minutes that a stage's job should request; attempt: from 1, later ones request more."""
    first = START_MINUTES + round(TIME_FACTOR * effort(stage, sizes).seconds / 60)
    return first * LONGER.get(stage, 2) ** (attempt - 1)


def sizes_of(path: str | Path) -> Sizes:
    """Return the sizes by the voxels and faces in a labels.npz, the facets in a .vtp or elements in a .vtu.

    If the file does not exist yet or has other content, the sizes in UNKNOWN for its suffix are returned;
    the stage that reads the file reports its faults. Another suffix may raise KeyError.
    """
    suffix = Path(path).suffix
    try:
        if suffix == ".npz":
            with zipfile.ZipFile(path) as archive:
                with archive.open("labels.npy") as stream:
                    np.lib.format.read_magic(stream)
                    voxels = np.prod(np.lib.format.read_array_header_1_0(stream)[0])
                with archive.open("faces.npy") as stream:
                    facets = FACETS_PER_FACE * int(np.lib.format.read_array(stream))
            return by_facets(facets, int(voxels))
        with open(path, "rb") as stream:
            found = _COUNTS.search(stream.read(HEAD))
        if found is None:
            return UNKNOWN[suffix]
        return by_facets(int(found[2]) / (1 if found[1] == b"Polys" else TETS_PER_FACET))
    except (OSError, zipfile.BadZipFile, KeyError, ValueError):
        return UNKNOWN[suffix]
