"""What each stage's job asks a cluster for: memory and time, by the size of what it works on."""

import re
import zipfile
from pathlib import Path

import numpy as np

from craftmesh.campaign.effort import Sizes, effort
from craftmesh.campaign.node import Node

# What is expected holds within a factor of 1.5 on the examples; a file's size says less than a plan knows.
MEMORY_FACTOR = 2
# Nodes are slower than the machine of the measurements, and shared; who asks for an hour waits no longer.
TIME_FACTOR = 10
COMPILER_MB = 500  # the kernels are compiled once on each kind of machine, which takes five minutes
START_MINUTES = 15
WORKER_MB = 400  # a worker process of tetrahedralize besides the first, on small grains
# the next attempt's time over that before; where a grain failed, assemble meshes the whole model
LONGER = {"assemble": 5}
# jobs of one group that run at once on its node: Snakemake asks for the sum of their memory
AT_ONCE = {"inp": 2, "check": 2}
# Facets of the remeshed surface over voxels at most: copper, whose grains are four voxels across, has 0.9.
FACETS_PER_VOXEL = 1.0
# Tetrahedra over facets of the gradated surface: grains430 9.9, al1050 10.
TETS_PER_FACET = 10.0
# What is counted before a file is made: voxels by those who make them, and facets where a plan is shown.
UNKNOWN = {".npz": 20_000_000, ".vtp": 100_000}


def memory_mb(stage: str, count: int, attempt: int, node: Node) -> int:
    """Return the memory of a stage's job on `count` facets or voxels, up to its part of the node's."""
    megabytes = MEMORY_FACTOR * effort(stage, _sizes(count)).megabytes + COMPILER_MB
    if stage == "tetrahedralize":
        megabytes += WORKER_MB * (node.workers - 1)
    asked = round(megabytes) * 2 ** (attempt - 1)
    return asked if node.mem_mb is None else min(asked, node.mem_mb // AT_ONCE.get(stage, 1))


def minutes(stage: str, count: int, attempt: int) -> int:
    """Return the time of a stage's job on `count` facets or voxels."""
    first = START_MINUTES + round(TIME_FACTOR * effort(stage, _sizes(count)).seconds / 60)
    return first * LONGER.get(stage, 2) ** (attempt - 1)


def _sizes(count: int) -> Sizes:
    """Return the sizes that go with a count of facets, or of voxels."""
    return Sizes(voxels=count, facets=count * FACETS_PER_VOXEL, elements=count * TETS_PER_FACET)


def count_of(path: str | Path) -> int:
    """Return the facets of a .vtp or the voxels of a labels.npz, by its head.

    UNKNOWN for a file that is not there yet or is none of these: the stage that reads it will say so.
    """
    suffix = Path(path).suffix
    try:
        if suffix == ".npz":
            with zipfile.ZipFile(path) as archive, archive.open("labels.npy") as stream:
                np.lib.format.read_magic(stream)
                return int(np.prod(np.lib.format.read_array_header_1_0(stream)[0]))
        with open(path, "rb") as stream:
            found = re.search(rb'NumberOfPolys="(\d+)', stream.read(4096))
        return int(found[1]) if found else UNKNOWN[suffix]
    except (OSError, zipfile.BadZipFile, KeyError, ValueError):
        return UNKNOWN[suffix]
