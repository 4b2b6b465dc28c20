"""How many elements an increment will have, and how long and how much memory its jobs will take.

Measured on a virtual machine with two cores (AMD EPYC), kernels compiled; docs/benchmarks.md has the table.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from craftmesh.sizing.lengths import Lengths
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


# Python and its libraries take a second and 120 to 250 MB in each job, a worker process as much again; the
# rest is by voxel, facet and element. A job of `tetrahedralize` is one of two; `report` is one for all.
_COSTS = {
    "generate": _Cost(2, 150, (10, 0, 0), (30, 0, 0)),
    "import_microstructure": _Cost(1.5, 220, (1, 0, 0), (50, 0, 0)),
    "remesh": _Cost(2, 190, (0, 35, 0), (0, 600, 0)),
    "crack": _Cost(1, 140, (0, 0, 0), (40, 0, 0)),
    "size": _Cost(1, 125, (0, 0, 0), (40, 0, 0)),
    "stitch": _Cost(4.5, 250, (0, 6, 0), (0, 440, 0)),
    "gradate": _Cost(3.2, 300, (0, 10.5, 3.2), (0, 270, 60)),
    "tetrahedralize": _Cost(4.7, 420, (0, 0, 16), (0, 0, 100)),
    "assemble": _Cost(1.6, 240, (0, 0, 11), (0, 0, 800)),
    "inp": _Cost(1.6, 240, (0, 0, 5), (0, 0, 550)),
    "export": _Cost(1.6, 240, (0, 0, 5), (0, 0, 550)),
    "check": _Cost(1.3, 230, (0, 0, 5), (0, 0, 360)),
    "solve": _Cost(2, 250, (0, 0, 77), (0, 0, 3200)),
    "fracture": _Cost(4, 320, (0, 0, 30), (0, 0, 900)),
    "grow": _Cost(2, 170, (0, 0, 0), (250, 0, 0)),
    "depict": _Cost(2.9, 340, (0, 0, 2.7), (0, 0, 260)),
    "report": _Cost(4, 300),
}
RULES = tuple(_COSTS)  # in the order of the work


def effort(rule: str, sizes: Sizes, chunks: int = 2) -> Effort:
    """Return what a job of a rule of the workflow takes; `chunks` jobs share an increment's tetrahedra."""
    cost = _COSTS[rule]
    share = 2 / chunks if rule == "tetrahedralize" else 1.0
    counts = (sizes.voxels, sizes.facets, sizes.elements)
    seconds = share * sum(rate * count for rate, count in zip(cost.microseconds, counts)) / 1e6
    megabytes = share * sum(rate * count for rate, count in zip(cost.bytes, counts)) / 1e6
    return Effort(cost.seconds + seconds, cost.megabytes + megabytes)


def expected_facets(voxels: Voxels) -> float:
    """Return about how many facets the grains' surface will have when it is remeshed."""
    labels = voxels.labels
    within = sum(np.count_nonzero(np.diff(labels, axis=axis)) for axis in range(3))
    on_box = sum(2 * labels.size // labels.shape[axis] for axis in range(3))
    return FACETS_PER_FACE * (within + on_box)


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
