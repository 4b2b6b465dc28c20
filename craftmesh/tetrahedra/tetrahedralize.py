"""Fill each grain with tetrahedra by its own call of a mesher, in worker processes that may fail."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from craftmesh.errors import MeshingError
from craftmesh.processes.pool import run_tasks
from craftmesh.progress import silent
from craftmesh.sizing.lengths import Lengths
from craftmesh.sizing.surface_sizing import LocalSizing
from craftmesh.tetrahedra.diagnose import GrainFailure, diagnose
from craftmesh.tetrahedra.grain_meshing import Attempt, MeshingTask, ladder, mesh_grain
from craftmesh.tetrahedra.grain_surface import GrainSurface, grain_surfaces
from craftmesh.tetrahedra.meshers.base import BUILT_IN, load_mesher
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.types import GrainTets, Surface

# Tetrahedra per unit of sum dV / l^3 are not known beforehand; facets are, and the time follows them.
FIXED_COST = 50.0


def tetrahedralize(
    surface: Surface,
    sizing: Lengths | None,
    islands: Iterable | None,
    options: TetrahedralizeOptions,
    grains: Iterable[int] | None = None,
    workers: int = 1,
    progress: Callable[[float, str], None] = silent,
) -> tuple[list[GrainTets], dict]:
    """Return the tetrahedra of each grain (default: all) by ascending id, and a report.

    The surface is kept: all facets, crack facets inside grains included, are faces of tetrahedra, and
    its nodes keep every bit. sizing: `at(points)` gives target edge lengths (Eq. 3), None takes the
    surface's own; islands: seeds of what lies within grains (`Island`), checked and found anew where
    they are off. The result does not depend on `workers`. Raises MeshingError, which carries what was
    done, when a grain fails in every attempt.
    """
    load_mesher(options.mesher)
    done: dict[int, tuple[GrainTets, dict]] = {}
    failures: list[GrainFailure] = []
    attempts = ladder(options.all_switches, options.interior_points)
    tasks = [_task(one, islands, attempts[0]) for one in grain_surfaces(surface, grains)]
    costs = [FIXED_COST + len(task.surface.facets) for task in tasks]
    total, spent = sum(costs), 0.0

    def tell(task: MeshingTask) -> None:
        nonlocal spent
        spent += FIXED_COST + len(task.surface.facets)
        progress(spent / total, f"{len(done) + len(failures)} of {len(tasks)} grains")

    def on_done(task: MeshingTask, value: tuple, seconds: float) -> None:
        grain_tets, figures = value
        tried = [*task.failed, _attempt_report(task.attempt, "meshed", seconds)]
        done[task.surface.grain] = grain_tets, figures | {"attempts": tried}
        tell(task)

    def on_failure(task: MeshingTask, failure, seconds: float) -> MeshingTask | None:
        attempt = _attempt_report(task.attempt, failure.reason, seconds)
        if task.rung + 1 < len(attempts):
            return task.next(attempts[task.rung + 1], attempt)
        ask = options.mesher in BUILT_IN
        failures.append(diagnose(task.surface, (*task.failed, attempt), failure.where, ask))
        tell(task)
        return None

    run_tasks(
        mesh_grain,
        (options, sizing),
        list(zip(costs, tasks)),
        on_done,
        on_failure,
        workers=workers,
        time_limit=options.time_limit,
        memory_limit=options.memory_limit,
        warm_up=compile_kernels,
    )
    result = [done[grain][0] for grain in sorted(done)]
    failures.sort(key=lambda failure: failure.grain)
    report = _report(done, failures)
    if failures:
        more = f" ({len(failures)} grains in all)" if len(failures) > 1 else ""
        what = "; repair the surface there (craftmesh check names its breaches)"
        raise MeshingError(failures[0].sentence() + more + what, tuple(failures), tuple(result), report)
    return result, report


def compile_kernels(shared: tuple[Any, Any]) -> None:
    """Mesh a small cube once, so that later time limits do not count compilation."""
    options = replace(shared[0], mesher="tetgen", interior_points=True, optimise=True)
    corners = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], indexing="ij"), -1).reshape(-1, 3)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    facets = np.array([[q[i] for i in half] for q in quads for half in ((0, 1, 2), (0, 2, 3))], np.int64)
    cube = GrainSurface(1, np.arange(8), corners, facets, np.zeros(12, bool), np.arange(12))
    task = MeshingTask(cube, np.zeros((0, 3)), Attempt("pYq1.4AQ", True))
    mesh_grain((options, LocalSizing(cube.points, cube.facets)), task)


def _task(surface: GrainSurface, islands: Iterable | None, attempt: Attempt) -> MeshingTask:
    seeds = [seed for island in islands or () if island.host == surface.grain for seed in island.seeds]
    return MeshingTask(surface, np.array(seeds, float).reshape(-1, 3), attempt)


def _attempt_report(attempt: Attempt, outcome: str, seconds: float) -> dict:
    return {
        "switches": attempt.switches,
        "interior_points": attempt.with_points,
        "reason": outcome,
        "seconds": seconds,
    }


def _report(done: dict, failures: list[GrainFailure]) -> dict:
    """Sums over grains, and per grain all that took more than one attempt."""
    figures = {grain: done[grain][1] for grain in sorted(done)}
    sums = {
        name: sum(one[name] for one in figures.values())
        for name in (
            "tets",
            "tets_meshed",
            "interior_points",
            "holes",
            "island_seeds_off",
            "scaffold_seconds",
            "points_seconds",
            "mesh_seconds",
            "optimise_seconds",
        )
    }
    return {
        "grains": len(done),
        **sums,
        "poor": {str(grain): one["poor"] for grain, one in figures.items() if one["poor"]},
        "tried_again": {
            str(grain): one["attempts"] for grain, one in figures.items() if len(one["attempts"]) > 1
        },
        "failed": {
            str(failure.grain): {
                "reason": failure.reason,
                "facets": failure.facet_ids.tolist(),
                "attempts": list(failure.attempts),
            }
            for failure in failures
        },
    }
