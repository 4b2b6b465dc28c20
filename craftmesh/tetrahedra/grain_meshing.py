"""One attempt at one grain: scaffold, interior points, mesh, checks, optimisation. Runs in a worker."""

from dataclasses import dataclass, field, replace
from time import process_time
from typing import Any

import numpy as np

from craftmesh.sizing.surface_sizing import LocalSizing
from craftmesh.surface.connectivity import compact
from craftmesh.tetrahedra.grain_region import (
    check_filled,
    find_regions,
    hole_seeds,
    replace_by_given,
)
from craftmesh.tetrahedra.grain_surface import GrainSurface
from craftmesh.tetrahedra.interior_points import interior_points
from craftmesh.tetrahedra.meshers.base import load_mesher
from craftmesh.tetrahedra.optimise_tets import optimise_tets
from craftmesh.tetrahedra.poor_tets import poor_tets
from craftmesh.types import GrainTets

# Keeps the surface, adds nothing it can do without: the cheapest mesh that tells inside from outside.
SCAFFOLD_SWITCHES = "pYAQ"
NO_POINTS = np.zeros((0, 3))


@dataclass(frozen=True)
class Attempt:
    """How a grain is tried: the mesher's switches, and whether with interior points."""

    switches: str
    with_points: bool
    scaffold: str = SCAFFOLD_SWITCHES


@dataclass(frozen=True)
class MeshingTask:
    """A grain to mesh, the seeds of islands within it, the attempt and those that failed before."""

    surface: GrainSurface
    seeds: np.ndarray
    attempt: Attempt
    rung: int = 0
    failed: tuple = field(default=())

    def next(self, attempt: Attempt, failure: dict) -> "MeshingTask":
        """Return the task of the next rung of the ladder."""
        return replace(self, attempt=attempt, rung=self.rung + 1, failed=(*self.failed, failure))


def ladder(switches: str, with_points: bool) -> list[Attempt]:
    """Return the attempts in order: as asked, then without points, without quality, coarser tolerance."""
    plain = SCAFFOLD_SWITCHES
    coarse = "pYT1e-12AQ"
    attempts = [Attempt(switches, with_points), Attempt(switches, False)]
    attempts += [Attempt(plain, with_points), Attempt(plain, False), Attempt(coarse, False, coarse)]
    return list(dict.fromkeys(attempts))


def mesh_grain(shared: tuple[Any, Any], task: MeshingTask) -> tuple[GrainTets, dict]:
    """Return the grain's tets and figures of the making. Raises WrongMesh and MesherRefusal."""
    options, sizing = shared
    surface, attempt = task.surface, task.attempt
    mesher = load_mesher(options.mesher)
    markers = np.where(surface.internal, 2, 1).astype(np.int32)
    sizing = LocalSizing(surface.points, surface.facets) if sizing is None else sizing
    clock = process_time()
    seconds = {}

    def lap(name: str) -> None:
        nonlocal clock
        now = process_time()
        seconds[name], clock = now - clock, now

    def run(points, holes, switches):
        return mesher.mesh(surface.points, surface.facets, markers, points, holes, switches)

    nodes, tets = run(NO_POINTS, NO_POINTS, attempt.scaffold)
    regions = find_regions(surface, tets)
    holes, seeds_off = replace_by_given(hole_seeds(nodes, tets, regions), task.seeds, nodes, tets, regions)
    lap("scaffold_seconds")
    points = NO_POINTS
    if attempt.with_points:
        points = interior_points(surface, nodes, tets[regions.kept], sizing)
    lap("points_seconds")
    if len(points) or attempt.switches != attempt.scaffold:
        nodes, tets = run(points, holes, attempt.switches)
        regions = find_regions(surface, tets)
    # every facet is a face, so all surface nodes are in use and stay first
    nodes, tets, _ = compact(nodes, tets[regions.kept])
    surface_nodes = len(surface.points)
    check_filled(surface, nodes, tets)
    lap("mesh_seconds")
    report = {
        "tets_meshed": len(tets),
        "holes": len(holes),
        "island_seeds_off": seeds_off,
        "interior_points": len(points),
    }
    if options.optimise:
        internal = surface.facets[surface.internal]
        nodes, tets, steps = optimise_tets(nodes, tets, surface_nodes, internal, sizing.at(nodes))
        find_regions(surface, tets)
        check_filled(surface, nodes, tets)
        report |= {"optimiser": steps}
    lap("optimise_seconds")
    result = GrainTets(surface.grain, surface.nodes, nodes[surface_nodes:], tets)
    poor = poor_tets(surface, nodes, tets) if options.optimise else []
    return result, report | {"tets": len(tets), "poor": poor} | seconds
