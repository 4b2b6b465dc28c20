"""Flat, poor and stretched tets that the surface forces: it gives way, to both neighbours alike."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from craftmesh.mesh.poor import is_flat, is_poor
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.opening_model import Opening, begun, moved, repaired, with_parting
from craftmesh.tetrahedra.opening_stages import JOINING, STAGES, Stage, is_stretched
from craftmesh.tetrahedra.poor_tets import poor_tets
from craftmesh.tetrahedra.surface_contractions import contracted
from craftmesh.tetrahedra.surface_partings import Parting, partings_at, worthwhile
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import GrainTets, Surface

# Rounds of contractions: what one leaves may be contracted in the next.
CONTRACTIONS = 3
# Rounds of partings. Of four random cracks with 4, 2, 1 and 23 flat tets 2, 1, 0 and 10 are left
# after up to three; later ones gain little.
PARTINGS = 4
# Edges that are parted at flat tets though that alone gains nothing. Of four random cracks with 1, 1, 3 and
# 12 flat tets 0, 0, 0 and 10 are left, after one, one, three and seven of these.
TRIES = 16


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
    """Return the surface and all grains' tets with fewer flat, poor (`mesh/poor`) and stretched ones.

    Nodes near such tets go to where the worst tet round them, in any grain, is better; those of the surface
    by up to 0.4 of the mean edge at them, as long as there are such tets, those of the box on its planes,
    those of a crack along it, those of its front not at all. Where that is not enough, edges of the surface
    are contracted at flat and poor ones. Last, edges of the surface are parted, at flat ones in twos and
    threes. After each change the grains there are repaired inside; what leaves no fewer such tets is not
    done. A function of the whole mesh, not of chunks.
    """
    before = begun(surface, grain_tets)
    if before is None:
        return GivenWay(surface, grain_tets)
    after = before
    for stage in (JOINING, *STAGES):
        after = _with_moves(after, stage)
        if stage.score is not None:
            after = _contracted(after, stage, stage.score)
    after = _parted_at_flat(_parted(after, STAGES[-1]), STAGES[-1])
    report = _report(before, after)
    model = after.model
    return GivenWay(model.surface, model.grain_tets, report, _poor(model, after.changed), _warning(report))


def _with_moves(now: Opening, stage: Stage) -> Opening:
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
        best = min(best, now, key=Opening.faults)
    return best


def _contracted(now: Opening, stage: Stage, score: float) -> Opening:
    """Return the best model with edges at bad tets contracted, and nodes moved again after that."""
    best = now
    for _ in range(CONTRACTIONS):
        bad = now.bad(stage.is_bad)
        if not bad.any():
            break
        model, grains, count = contracted(now.model, bad, score)
        if not count:
            break
        now = _with_moves(now.replaced(repaired(model, grains, stage.aim), grains, count), stage)
        best = min(best, now, key=Opening.faults)
    return best


def _parted(now: Opening, stage: Stage) -> Opening:
    """Return the best model with edges at bad tets parted where that gains, and nodes moved after that."""
    best = now
    for _ in range(PARTINGS):
        parting = worthwhile(now.model, now.bad(stage.is_bad))
        if not len(parting.edges):
            break
        now, grains = with_parting(now, parting)
        now = _with_moves(now.replaced(repaired(now.model, grains, stage.aim), grains), stage)
        best = min(best, now, key=Opening.faults)
    return best


def _parted_at_flat(now: Opening, stage: Stage) -> Opening:
    """Return the best model with edges at flat tets parted one by one, and what gains then.

    A needle between two long edges is flat with either of them parted, and sound with both.
    """
    best, offered = now, _at_flat(now)
    tried: set[bytes] = set()
    while len(tried) < TRIES:
        parting = next(offered, None)
        if parting is None:
            break
        place = parting.places(best.model.points).tobytes()
        if place in tried:
            continue
        tried.add(place)
        after = _parted(with_parting(best, parting)[0], stage)
        if after.faults() < best.faults():
            best, offered = after, _at_flat(after)
    return best


def _at_flat(now: Opening) -> Iterator[Parting]:
    return partings_at(now.model, np.flatnonzero(now.bad(is_flat)))


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
        "edges_contracted": after.contracted,
        "edges_parted": after.parted,
        "volume_drift_worst": max(map(abs, after.drifts().values()), default=0.0),
    }


def _warning(report: dict) -> str | None:
    changes = ("surface_points_moved", "edges_contracted", "edges_parted")
    if not report["poor_before"] or not any(map(report.get, changes)):
        return None
    return (
        f"{report['poor_before']} poor tetrahedra, {report['flat_before']} of them flat, lie where the "
        f"surface leaves no room: {report['surface_points_moved']} of its points were moved by up to "
        f"{report['largest_move']:.3g}, {report['edges_contracted']} of its edges contracted and "
        f"{report['edges_parted']} parted, for both neighbours alike; {report['poor_left']} poor and "
        f"{report['flat_left']} flat ones are left, the largest change of a volume is "
        f"{100 * report['volume_drift_worst']:.2g} %"
    )


def _poor(model: Model, grains: np.ndarray) -> dict[str, list[dict]]:
    """Return the rows of `poor_tets` of the grains."""
    tets_of = {one.grain: one for one in model.grain_tets}
    result = {}
    for surface in grain_surfaces(model.surface, grains):
        one = tets_of[surface.grain]
        nodes = np.concatenate([model.surface.points[one.nodes], one.interior])
        result[str(surface.grain)] = poor_tets(surface, nodes, one.tets)
    return result
