"""Flat, poor and stretched tets that the surface forces: it gives way, to both neighbours alike."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import attrgetter

import numpy as np

from craftmesh.mesh.shape_measures import is_flat, is_poor
from craftmesh.tetrahedra.opening_model import (
    STAGES,
    Opening,
    Stage,
    begun,
    is_stretched,
    moved,
)
from craftmesh.tetrahedra.record import poor_by_grain
from craftmesh.types import GrainTets, Surface


def with_moves(now: Opening, stage: Stage) -> Opening:
    """Return the best of the models with nodes near bad tets moved, further each round."""
    best, held = now, now.changed_by(stage.drift)
    for reach in stage.reaches:
        bad = now.bad(stage.is_bad)
        if not bad.any():
            break
        after = moved(now, reach, bad, stage, held)
        while over := after.changed_by(stage.drift) - held:
            held |= over
            after = moved(now, reach, bad, stage, held)
        now = after
        best = min(best, now, key=attrgetter("faults"))
    return best


@dataclass(frozen=True)
class GivenWay:
    """Surface and tets of all grains after flat, poor and stretched tets were opened.

    report: counts and the largest move, None without such tets; poor: the rows of `poor_tets` of the
    grains changed; warning: what was moved for poor tets in one line.
    """

    surface: Surface
    grain_tets: Sequence[GrainTets]
    report: dict | None = None
    poor: dict[str, list[dict]] = field(default_factory=dict)
    warning: str | None = None


def given_way(surface: Surface, grain_tets: Sequence[GrainTets]) -> GivenWay:
    """Return the surface and all grains' tets with fewer flat, poor, stretched and narrow ones.

    What these are: `mesh/shape_measures`, `opening_model`.

    Nodes near such tets go to where the worst tet round them, in any grain, is better; those of the surface
    by up to 0.4 of the mean edge at them, as long as there are such tets, those of the box on its planes,
    those of a crack along it, those of its front not at all. Last, nodes at narrow ones go to where these
    are less so, by up to 0.1 of the mean edge. After each change the grains there are repaired inside; what
    leaves no fewer such tets is not done. A function of the whole mesh, not of chunks.
    """
    before = begun(surface, grain_tets)
    if before is None:
        return GivenWay(surface, grain_tets)
    after = before
    for stage in STAGES:
        after = with_moves(after, stage)
    report = _report(before, after)
    model = after.model
    poor = poor_by_grain(model.surface, model.grain_tets, after.changed)
    return GivenWay(model.surface, model.grain_tets, report, poor, _warning(report))


def _report(before: Opening, after: Opening) -> dict:
    surface, homes = after.model.surface, after.homes
    moves = np.linalg.norm(surface.points - homes, axis=1)
    return {
        "flat_before": before.count(is_flat),
        "flat_left": after.count(is_flat),
        "poor_before": before.count(is_poor),
        "poor_left": after.count(is_poor),
        "stretched_before": before.count(is_stretched),
        "stretched_left": after.count(is_stretched),
        "surface_points_moved": int((moves > 0).sum()),
        "largest_move": float(moves.max()),
        "volume_drift_worst": max(map(abs, after.drifts.values()), default=0.0),
    }


def _warning(report: dict) -> str | None:
    if not report["poor_before"] or not report["surface_points_moved"]:
        return None
    return (
        f"{report['poor_before']} poor tetrahedra, {report['flat_before']} of them flat, lie where the "
        f"surface leaves no room: {report['surface_points_moved']} of its points were moved by up to "
        f"{report['largest_move']:.3g}, for both neighbours alike; {report['poor_left']} poor and "
        f"{report['flat_left']} flat ones are left, the largest change of a volume is "
        f"{100 * report['volume_drift_worst']:.2g} %"
    )
