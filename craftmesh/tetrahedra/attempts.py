"""The attempts at a grain, from what is asked for down to what any mesher should manage."""

from dataclasses import dataclass, field, replace

import numpy as np

from craftmesh.tetrahedra.grain_surface import GrainSurface

# Keeps the surface, adds nothing it can do without: the cheapest mesh that tells inside from outside.
SCAFFOLD_SWITCHES = "pYAQ"
# The same with TetGen's coplanarity tolerance at 1e-12 in place of 1e-8, its default.
COARSE_SWITCHES = "pYT1e-12AQ"


@dataclass(frozen=True)
class Attempt:
    """How a grain is tried: the mesher's switches, and whether with interior points."""

    switches: str
    with_points: bool
    scaffold: str = SCAFFOLD_SWITCHES

    def report(self, outcome: str, seconds: float) -> dict:
        """Return the attempt as reports list it; outcome: "meshed" or the reason why not."""
        return {
            "switches": self.switches,
            "interior_points": self.with_points,
            "reason": outcome,
            "seconds": seconds,
        }


@dataclass(frozen=True)
class MeshingTask:
    """A grain to mesh, seeds (k, 3) of islands within it, the attempt and those that failed before."""

    surface: GrainSurface
    seeds: np.ndarray
    attempt: Attempt
    rung: int = 0
    failed: tuple = field(default=())

    def next(self, attempt: Attempt, failure: dict) -> "MeshingTask":
        """Return the task of the next rung of the ladder."""
        return replace(self, attempt=attempt, rung=self.rung + 1, failed=(*self.failed, failure))


def attempts(switches: str, with_points: bool) -> list[Attempt]:
    """Return the attempts in order: as asked, then without points, without quality, another tolerance."""
    tried = [Attempt(switches, with_points), Attempt(switches, False)]
    tried += [Attempt(SCAFFOLD_SWITCHES, with_points), Attempt(SCAFFOLD_SWITCHES, False)]
    tried.append(Attempt(COARSE_SWITCHES, False, COARSE_SWITCHES))
    return list(dict.fromkeys(tried))
