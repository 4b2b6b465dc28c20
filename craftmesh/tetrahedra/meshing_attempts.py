"""The ladder: a series of attempts at each grain, until one of them gives its tetrahedra."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from craftmesh.processes.job import Failure
from craftmesh.tetrahedra.diagnose import GrainFailure, diagnose
from craftmesh.tetrahedra.grain_surface import GrainSurface
from craftmesh.types import GrainTets

# TetGen switches that keep the surface and add only necessary points: the cheapest mesh that separates
# inside from outside.
SCAFFOLD_SWITCHES = "pYAQ"
# The same with TetGen's coplanarity tolerance at 1e-12 instead of the default 1e-8.
COARSE_SWITCHES = "pYT1e-12AQ"


@dataclass(frozen=True)
class Attempt:
    """One way to mesh a grain.

    switches: for the mesher; with_points: whether interior points are placed first; scaffold: switches for
    the scaffold, the first mesh that separates inside from outside.
    """

    switches: str
    with_points: bool
    scaffold: str = SCAFFOLD_SWITCHES

    def report(self, outcome: str, seconds: float) -> dict:
        """Return the attempt as a dict for JSON; outcome: its `reason`, "meshed" or why it failed."""
        return {
            "switches": self.switches,
            "interior_points": self.with_points,
            "reason": outcome,
            "seconds": seconds,
        }


@dataclass(frozen=True)
class MeshingTask:
    """A grain to mesh by one attempt.

    seeds (k, 3): points in the islands, the voids and grains inside the grain; rung: number of the attempt,
    from 0; failed: reports of the attempts before it.
    """

    surface: GrainSurface
    seeds: np.ndarray
    attempt: Attempt
    rung: int = 0
    failed: tuple = field(default=())

    def next(self, attempt: Attempt, failure: dict) -> "MeshingTask":
        """Return the task with the next attempt; failure: report of this task's attempt."""
        return replace(self, attempt=attempt, rung=self.rung + 1, failed=(*self.failed, failure))


def attempts(switches: str, with_points: bool) -> list[Attempt]:
    """Return the distinct attempts at a grain, in order.

    First the given switches, with and without interior points; then the same without quality bounds; last,
    without points, a smaller coplanarity tolerance. Without `with_points`, no attempt has interior points.
    """
    tried = [Attempt(switches, with_points), Attempt(switches, False)]
    tried += [Attempt(SCAFFOLD_SWITCHES, with_points), Attempt(SCAFFOLD_SWITCHES, False)]
    tried.append(Attempt(COARSE_SWITCHES, False, COARSE_SWITCHES))
    return list(dict.fromkeys(tried))


# Keys of the grains' reports whose values the report of all grains sums.
SUMMED = (
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


class Ladder:
    """The attempts at all grains and their results.

    It is a Listener: `run_tasks` calls on_done and on_failure for each task. ask_tetgen: whether TetGen's
    own diagnosis is used for grains that fail every attempt.
    """

    def __init__(
        self,
        attempts: Sequence[Attempt],
        surfaces: Sequence[GrainSurface],
        ask_tetgen: bool,
        progress: Callable[[float, str], None],
    ):
        self.attempts, self.surfaces = attempts, surfaces
        self.ask_tetgen, self.progress = ask_tetgen, progress
        self.done: dict[int, tuple[GrainTets, dict]] = {}
        self.failures: list[GrainFailure] = []
        self.spent, self.total = 0, sum(len(one.facets) for one in surfaces)

    def tasks(self, islands: Iterable[Any]) -> list[tuple[float, MeshingTask]]:
        """Return the cost and the first task of each grain; the cost is the number of facets.

        islands: voids and grains inside grains, with attributes `host` (a grain id) and `seeds`.
        """
        seeds: dict[int, list] = {}
        for island in islands:
            seeds.setdefault(island.host, []).extend(island.seeds)
        return [
            (
                float(len(one.facets)),
                MeshingTask(
                    one, np.array(seeds.get(one.grain, ()), float).reshape(-1, 3), self.attempts[0]
                ),
            )
            for one in self.surfaces
        ]

    def on_done(self, task: MeshingTask, value: tuple[GrainTets, dict], seconds: float) -> None:
        """Store a grain's tets and report, and report the progress."""
        grain_tets, figures = value
        tried = [*task.failed, task.attempt.report("meshed", seconds)]
        self.done[task.surface.grain] = grain_tets, figures | {"attempts": tried}
        self._tell(task)

    def on_failure(self, task: MeshingTask, failure: Failure, seconds: float) -> MeshingTask | None:
        """Return the task of the next attempt; after the last one, diagnose and store the failure: None."""
        attempt = task.attempt.report(failure.reason, seconds)
        if task.rung + 1 < len(self.attempts):
            return task.next(self.attempts[task.rung + 1], attempt)
        tried = (*task.failed, attempt)
        self.failures.append(diagnose(task.surface, tried, failure.where, self.ask_tetgen))
        self._tell(task)
        return None

    def _tell(self, task: MeshingTask) -> None:
        self.spent += len(task.surface.facets)
        settled = len(self.done) + len(self.failures)
        self.progress(self.spent / self.total, f"{settled} of {len(self.surfaces)} grains")

    def grain_tets(self) -> list[GrainTets]:
        """Return the tets of the grains that are done, by ascending id."""
        return [self.done[grain][0] for grain in sorted(self.done)]

    def failed(self) -> tuple[GrainFailure, ...]:
        """Return the grains that failed every attempt, by ascending id."""
        return tuple(sorted(self.failures, key=lambda failure: failure.grain))

    def report(self) -> dict:
        """Return the report of all grains, for JSON.

        It has the number `grains` of meshed grains, sums over them (SUMMED), and dicts by grain id (as
        text): `poor` tets, `tried_again` (attempts of grains that needed more than one) and `failed`.
        """
        figures = {grain: self.done[grain][1] for grain in sorted(self.done)}
        return {
            "grains": len(self.done),
            **{name: sum(one[name] for one in figures.values()) for name in SUMMED},
            "poor": {str(grain): one["poor"] for grain, one in figures.items() if one["poor"]},
            "tried_again": {
                str(grain): one["attempts"] for grain, one in figures.items() if len(one["attempts"]) > 1
            },
            "failed": {str(failure.grain): failure.report() for failure in self.failed()},
        }
