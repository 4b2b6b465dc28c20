"""How many elements an increment will have, how long and how much memory its jobs take, and ask for.

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

from craftmesh.io.declared import HEAD
from craftmesh.options import Options, option
from craftmesh.sizing.sizing import Lengths
from craftmesh.types import Voxels

# Tetrahedra over the integral of dV / l^3. Measured on demo, al6xn, al1050 and copper, sizes and cracks
# differing: 10.0 to 11.9; equal regular tetrahedra would fill space with 8.5.
TETS_PER_CUBE = 11.0
# Facets of the remeshed surface over the voxel faces between labels and on the box: demo 2.3, al1050 2.3,
# al6xn 2.4, copper, whose grains are four voxels across, 3.5.
FACETS_PER_FACE = 2.5
# Cells of the integral to begin with; those wider than COARSE lengths are halved, up to MOST_CELLS. Penny
# cracks with r0 of two voxels and more are within 4 % of a sum over three million cells.
CELLS, COARSE, MOST_CELLS = 8_000, 2.0, 300_000
OCTANTS = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))


@dataclass(frozen=True)
class Sizes:
    """What the jobs of an increment grow with: counts of voxels, of facets as remeshed, of elements."""

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
    """What a job takes at least, and what for each voxel, facet and element: microseconds and bytes."""

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
# CPU seconds of a job's start, which children of one process share: 38 jobs of a small growing crack took
# 78 s where each started alone, 36 s where they shared one
START = 1.0
RULES = tuple(_COSTS)  # in the order of the work


def effort(rule: str, sizes: Sizes, chunks: int = 2, is_warm: bool = False) -> Effort:
    """Return the CPU seconds and megabytes that a job of a workflow rule takes.

    chunks: number of jobs that share an increment's tetrahedra. is_warm: whether stages run in children of
    one process.
    """
    cost = _COSTS[rule]
    share = 2 / chunks if rule == "tetrahedralize" else 1.0
    counts = (sizes.voxels, sizes.facets, sizes.elements)
    seconds = share * sum(rate * count for rate, count in zip(cost.microseconds, counts)) / 1e6
    megabytes = share * sum(rate * count for rate, count in zip(cost.bytes, counts)) / 1e6
    return Effort(cost.seconds - START * is_warm + seconds, cost.megabytes + megabytes)


def expected_facets(voxels: Voxels) -> float:
    """Return about how many facets the grains' surface will have when it is remeshed."""
    return FACETS_PER_FACE * voxels.faces


def expected_elements(voxels: Voxels, lengths: Lengths) -> float:
    """Return about how many tetrahedra of the target `lengths` fill the grains of the volume."""
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


# Jobs inherit what was found when the campaign was planned, and do not ask the cluster's controller again.
VARIABLE = "CRAFTMESH_NODE"
ANSWERS_WITHIN = 20  # seconds that a busy controller may take
# worker processes of a job of tetrahedra: its grains are few, and the largest one takes as long as the rest
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


# What is expected holds within a factor of 1.5 on the examples. Facets say less than a plan knows of
# elements: uniform meshes of examples/paper_2 and paper_3 have 17 and 21 to a facet. Jobs on a volume.vtu
# have them counted.
MEMORY_FACTOR, COUNTED_FACTOR = 2.0, 1.25
COUNTED = ("export", "solve", "fracture", "depict")
# Nodes are slower than the machine of the measurements, and shared; who asks for an hour waits no longer.
TIME_FACTOR = 10
COMPILER_MB = 500  # the kernels are compiled once on each kind of machine, which takes five minutes
START_MINUTES = 15
WORKER_MB = 400  # a worker process of tetrahedralize or renew besides the first, on small grains
# the next attempt's time over that before; where a grain failed, these mesh the whole model
LONGER = {"assemble": 5, "renew": 5}
# jobs of one group that run at once on its node: Snakemake asks for the sum of their memory
AT_ONCE = {"inp": 2, "check": 2}
# Tetrahedra over facets of the gradated surface: grains430 9.9, al1050 10.
TETS_PER_FACET = 10.0
_COUNTS = re.compile(rb'NumberOf(Polys|Cells)="(\d+)')


def by_facets(facets: float, voxels: float | None = None) -> Sizes:
    """Return the sizes where facets are known, as many voxels as facets where these are not."""
    return Sizes(facets if voxels is None else voxels, facets, TETS_PER_FACET * facets)


# Sizes assumed for a file that does not exist yet, by suffix: 2e7 voxels, or 1e5 facets. Snakemake may ask
# for a job's memory and time before the file is made; `plan` counts voxels and facets itself.
UNKNOWN = {".npz": by_facets(2e7), ".vtp": by_facets(1e5), ".vtu": by_facets(1e5)}


def memory_mb(stage: str, sizes: Sizes, attempt: int, node: Node) -> int:
    """Return the memory of a stage's job, up to its part of the node's."""
    factor = COUNTED_FACTOR if stage in COUNTED else MEMORY_FACTOR
    megabytes = factor * effort(stage, sizes).megabytes + COMPILER_MB
    if stage in ("tetrahedralize", "renew"):
        megabytes += WORKER_MB * (node.workers - 1)
    asked = round(megabytes) * 2 ** (attempt - 1)
    return asked if node.mem_mb is None else min(asked, node.mem_mb // AT_ONCE.get(stage, 1))


def minutes(stage: str, sizes: Sizes, attempt: int) -> int:
    """Return the time of a stage's job."""
    first = START_MINUTES + round(TIME_FACTOR * effort(stage, sizes).seconds / 60)
    return first * LONGER.get(stage, 2) ** (attempt - 1)


def sizes_of(path: str | Path) -> Sizes:
    """Return the sizes by the voxels and faces in a labels.npz, the facets in a .vtp or elements in a .vtu.

    If the file does not exist yet or has other content, UNKNOWN's sizes for its suffix are returned; the
    stage that reads the file reports its faults. Other suffixes are not accepted.
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
