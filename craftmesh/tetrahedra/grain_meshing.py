"""One attempt at one grain: scaffold, interior points, mesh, checks, optimisation. Runs in a worker."""

from dataclasses import dataclass
from time import process_time
from typing import Any

import numpy as np

from craftmesh.sizing.length_field import LocalSizing
from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.connectivity import compact
from craftmesh.tetrahedra.grain_region import (
    Regions,
    check_filled,
    find_regions,
    hole_seeds,
    replace_by_given,
)
from craftmesh.tetrahedra.grain_surface import GrainSurface
from craftmesh.tetrahedra.interior_points import interior_points
from craftmesh.tetrahedra.meshers import load_mesher
from craftmesh.tetrahedra.meshing_attempts import MeshingTask
from craftmesh.tetrahedra.optimise_tets import optimise_tets
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.record import poor_tets
from craftmesh.types import GrainTets

NO_POINTS = np.zeros((0, 3))
# Markers of facets for the mesher: any two different numbers > 0.
BOUNDARY_MARKER, INTERNAL_MARKER = 1, 2


@dataclass(frozen=True)
class Setting:
    """Options and target edge lengths for all grains.

    With sizing None the target lengths follow the surface edges of each grain. cell: edge of the first
    cells of the interior points' lattice; None: each grain has its own.
    """

    options: TetrahedralizeOptions
    sizing: Lengths | None
    cell: float | None = None


@dataclass(frozen=True)
class Scaffold:
    """A first mesh without added points, which separates inside from outside.

    nodes (n, 3), tets (t, 4); regions: their regions and those in the grain; holes (h, 3): seeds, one point
    in each region to leave empty; seeds_off: number of given seeds that lie in no such region.
    """

    nodes: np.ndarray
    tets: np.ndarray
    regions: Regions
    holes: np.ndarray
    seeds_off: int


class Stopwatch:
    """CPU seconds of each step, by name."""

    def __init__(self) -> None:
        self.last = process_time()
        self.seconds: dict[str, float] = {}

    def lap(self, name: str) -> None:
        """Store the seconds since the last call under `name`."""
        now = process_time()
        self.seconds[name], self.last = now - self.last, now


def mesh_grain(setting: Setting, task: MeshingTask) -> tuple[GrainTets, dict]:
    """Return a grain's tets by one attempt, and a report.

    The report has the numbers of tets, holes and interior points, the poor tets (only if they were
    optimised), and the CPU seconds of each step.

    Raises MesherRefusal if the mesher gives no mesh, and WrongMesh if its mesh does not fill the grain.
    """
    surface, options = task.surface, setting.options
    sizing = LocalSizing(surface.points, surface.facets) if setting.sizing is None else setting.sizing
    watch = Stopwatch()
    first = scaffold(task, options.mesher)
    watch.lap("scaffold_seconds")
    points = NO_POINTS
    if task.attempt.with_points:
        inside = first.tets[first.regions.kept]
        points = interior_points(surface, first.nodes, inside, sizing, setting.cell)
    watch.lap("points_seconds")
    nodes, tets = filled(task, options.mesher, first, points)
    watch.lap("mesh_seconds")
    report: dict[str, Any] = {
        "tets_meshed": len(tets),
        "holes": len(first.holes),
        "island_seeds_off": first.seeds_off,
        "interior_points": len(points),
    }
    if options.optimise:
        nodes, tets, steps = optimised(surface, nodes, tets, sizing)
        report |= {"optimiser": steps}
    watch.lap("optimise_seconds")
    result = GrainTets(surface.grain, surface.nodes, nodes[len(surface.points) :], tets)
    poor = poor_tets(surface, nodes, tets) if options.optimise else []
    return result, report | {"tets": len(tets), "poor": poor} | watch.seconds


def scaffold(task: MeshingTask, mesher: str) -> Scaffold:
    """Return the scaffold, the first mesh of a grain, with seeds: points in the regions to leave empty."""
    nodes, tets = _mesh(task.surface, mesher, NO_POINTS, NO_POINTS, task.attempt.scaffold)
    regions = find_regions(task.surface, tets)
    seeds = hole_seeds(nodes, tets, regions)
    holes, seeds_off = replace_by_given(seeds, task.seeds, nodes, tets, regions)
    return Scaffold(nodes, tets, regions, holes, seeds_off)


def filled(
    task: MeshingTask, mesher: str, first: Scaffold, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes (n, 3), the surface's points first, and tets (t, 4) that fill the grain.

    first: the scaffold, the grain's first mesh. points (p, 3): interior points that become nodes. Without
    them, and if the attempt's mesher switches equal those of the scaffold, the mesher is not run again and
    the scaffold's tets are returned. Raises WrongMesh if the tets do not fill the grain.
    """
    surface, switches = task.surface, task.attempt.switches
    nodes, tets, regions = first.nodes, first.tets, first.regions
    if len(points) or switches != task.attempt.scaffold:
        nodes, tets = _mesh(surface, mesher, points, first.holes, switches)
        regions = find_regions(surface, tets)
    # every facet is a face, so all surface nodes are in use and stay first
    nodes, tets, _ = compact(nodes, tets[regions.kept])
    check_filled(surface, nodes, tets)
    return nodes, tets


def optimised(
    surface: GrainSurface, nodes: np.ndarray, tets: np.ndarray, sizing: Lengths
) -> tuple[np.ndarray, np.ndarray, dict]:
    """Return improved nodes (n, 3) and tets (t, 4), and the numbers of operations by name (KINDS).

    The result is checked like the mesher's mesh; raises WrongMesh if it does not fill the grain.
    """
    internal = surface.facets[surface.internal]
    nodes, tets, steps = optimise_tets(nodes, tets, len(surface.points), internal, sizing.at(nodes))
    check_filled(surface, nodes, tets)
    return nodes, tets, steps


def _mesh(
    surface: GrainSurface, mesher: str, points: np.ndarray, holes: np.ndarray, switches: str
) -> tuple[np.ndarray, np.ndarray]:
    markers = np.where(surface.internal, INTERNAL_MARKER, BOUNDARY_MARKER).astype(np.int32)
    return load_mesher(mesher).mesh(surface.points, surface.facets, markers, points, holes, switches)
