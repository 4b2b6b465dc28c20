"""Flat, poor and stretched tets that the surface forces: it gives way, to both neighbours alike."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from craftmesh.mesh.kernels.shape_measures import shape_measures
from craftmesh.mesh.poor import is_flat, is_poor
from craftmesh.mesh.tet_connectivity import tet_edges
from craftmesh.sizing.surface_sizing import LocalSizing
from craftmesh.surface.measure import side_volumes, volume_drift
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.kernels.tet_cavity import TETS, new_scratch
from craftmesh.tetrahedra.kernels.tet_faults import OF_FLAT, OF_POOR, SOUND_FROM
from craftmesh.tetrahedra.kernels.tet_quality import WHOLE, Aim, all_qualities
from craftmesh.tetrahedra.kernels.tet_surface_moves import move_nodes
from craftmesh.tetrahedra.opening_stages import JOINING, STAGES, Stage, is_at_fault, is_stretched
from craftmesh.tetrahedra.optimise_tets import new_state, repaired_tets
from craftmesh.tetrahedra.poor_tets import poor_tets
from craftmesh.tetrahedra.surface_contractions import contracted
from craftmesh.tetrahedra.surface_freedom import Freedom, freedom
from craftmesh.tetrahedra.surface_partings import parted
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import GrainTets, Surface

# Rounds of contractions: what one leaves may be contracted in the next.
CONTRACTIONS = 3
# Rounds of partings. Of four random cracks with 4, 2, 1 and 23 flat tets 2, 1, 0 and 10 are left
# after up to three; later ones gain little.
PARTINGS = 4
# Sweeps over the nodes near a flat tet in a round.
SWEEPS = 3


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
    are contracted at flat and poor ones. Last, edges of the surface are parted. After each change the
    grains there are repaired inside; what leaves no fewer such tets is not done. A function of the whole
    mesh, not of chunks.
    """
    model = Model(surface, list(grain_tets))
    measures = _measures(model, {}, surface.grains)
    if not any(is_at_fault(one).any() for one in measures.values()):
        return GivenWay(surface, grain_tets)
    before = after = Opening(model, measures, surface.points, freedom(surface))
    for stage in (JOINING, *STAGES):
        after = _with_moves(after, stage)
        if stage.score is not None:
            after = _contracted(after, stage, stage.score)
    after = _parted(after, STAGES[-1])
    report = _report(before, after)
    model = after.model
    return GivenWay(model.surface, model.grain_tets, report, _poor(model, after.changed), _warning(report))


@dataclass(frozen=True)
class Opening:
    """A model while its surface gives way: the measures of its tets by grain, and what was done to it.

    homes (n, 3): the surface's points at first, and where its edges were parted; free: how they may move;
    changed: grains; contracted and parted: how many edges.
    """

    model: Model
    measures: Mapping[int, np.ndarray]
    homes: np.ndarray
    free: Freedom
    changed: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    contracted: int = 0
    parted: int = 0

    def bad(self, is_bad: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return (m,) bool: the tets that are bad."""
        return np.concatenate([is_bad(self.measures[one.grain]) for one in self.model.grain_tets])

    def count(self, is_bad: Callable[[np.ndarray], np.ndarray]) -> int:
        """Return how many tets are bad."""
        return int(self.bad(is_bad).sum())

    def drifts(self) -> dict[int, float]:
        """Return the relative changes of the volumes, by label."""
        surface = self.model.surface
        volumes = [side_volumes(at, surface.facets, surface.sides) for at in (self.homes, surface.points)]
        return volume_drift(*volumes)

    def mobile(self, drift: float) -> np.ndarray:
        """Return (n,) bool: surface nodes that may move, none of a volume that changed by over `drift`."""
        result = np.any(self.free.steps != 0, axis=(1, 2))
        if np.isfinite(drift):
            changed = [label for label, change in self.drifts().items() if abs(change) > drift]
            surface = self.model.surface
            result[surface.facets[np.isin(surface.sides, changed).any(axis=1)]] = False
        return result

    def faults(self) -> float:
        """Return the number of its flat, poor and stretched tets, by their weights."""
        return OF_FLAT * self.count(is_flat) + OF_POOR * self.count(is_poor) + self.count(is_stretched)

    def replaced(self, model: Model, grains: np.ndarray, contracted: int = 0) -> "Opening":
        """Return the opening with another model, whose tets differ in `grains` alone."""
        same = model.surface.facets is self.model.surface.facets
        return replace(
            self,
            model=model,
            free=self.free if same else freedom(model.surface),
            measures=_measures(model, self.measures, grains),
            changed=np.union1d(self.changed, grains),
            contracted=self.contracted + contracted,
        )


def _measures(
    model: Model, known: Mapping[int, np.ndarray], grains: np.ndarray
) -> Mapping[int, np.ndarray]:
    """Return the measures of each grain's tets, those of `grains` anew."""
    result, points = dict(known), model.surface.points
    for one in model.grain_tets:
        if one.grain in grains:
            result[one.grain] = shape_measures(np.concatenate([points[one.nodes], one.interior]), one.tets)
    return result


def _with_moves(now: Opening, stage: Stage) -> Opening:
    """Return the best of the models with nodes near bad tets moved, further each round."""
    best = now
    for reach in stage.reaches:
        bad = now.bad(stage.is_bad)
        if not bad.any():
            break
        points, grains = _moved_points(now, reach, bad, stage)
        now = now.replaced(_repaired(now.model.moved(points), grains, stage.aim), grains)
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
        now = _with_moves(now.replaced(_repaired(model, grains, stage.aim), grains, count), stage)
        best = min(best, now, key=Opening.faults)
    return best


def _parted(now: Opening, stage: Stage) -> Opening:
    """Return the best model with edges at bad tets parted, and nodes moved after that."""
    best = now
    for _ in range(PARTINGS):
        model, grains, parting = parted(now.model, now.bad(stage.is_bad))
        if not len(grains):
            break
        homes = np.concatenate([now.homes, parting.places(now.homes)])
        now = replace(now, homes=homes, parted=now.parted + len(parting.edges))
        now = _with_moves(now.replaced(_repaired(model, grains, stage.aim), grains), stage)
        best = min(best, now, key=Opening.faults)
    return best


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
    if not report["poor_before"] or not any(report[name] for name in changes):
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


def _moved_points(
    now: Opening, reach: float, bad: np.ndarray, stage: Stage
) -> tuple[np.ndarray, np.ndarray]:
    """Return all nodes, those near bad tets moved, and the grains that see a move.

    reach: the largest move of a surface point from its home, in mean edges.
    """
    points, tets, homes = now.model.points, now.model.tets, now.homes
    nodes = _nodes_near(tets, bad, now.mobile(stage.drift))
    near = np.zeros(len(points), bool)
    near[nodes] = True
    rows = np.flatnonzero(near[tets].any(axis=1))
    used, local = np.unique(tets[rows], return_inverse=True)
    state = new_state(points[used], local.reshape(-1, 4))
    goal = stage.aim or Aim(WHOLE, SOUND_FROM)
    all_qualities(state.points, state.tets, state.counts[TETS], state.quality, goal.measure)
    outer = nodes < len(homes)
    home, steps, part = points[nodes], np.repeat(np.eye(3)[None], len(nodes), axis=0), np.ones(len(nodes))
    home[outer], steps[outer], part[outer] = homes[nodes[outer]], now.free.steps[nodes[outer]], reach
    furthest = part * _mean_edges(points, tets[rows])[nodes]
    furthest[outer] = np.minimum(furthest[outer], now.free.reach[nodes[outer]])
    valence = np.bincount(tets[rows].ravel(), minlength=len(points))[nodes]
    work, place = new_scratch(), np.searchsorted(used, nodes)
    for _ in range(SWEEPS):
        if not move_nodes(state, place, home, furthest, steps, valence, goal, stage.aim is None, work):
            break
    moved = points.copy()
    moved[used] = state.points[: len(used)]
    changed = (moved != points).any(axis=1)
    return moved, np.unique(now.model.grain[changed[tets].any(axis=1)])


def _nodes_near(tets: np.ndarray, bad: np.ndarray, mobile: np.ndarray) -> np.ndarray:
    """Return the nodes of bad tets, and of those that share a node with them, that may move."""
    near = np.zeros(int(tets.max()) + 1, bool)
    near[tets[bad].ravel()] = True
    near[tets[near[tets].any(axis=1)].ravel()] = True
    near[: len(mobile)] &= mobile
    return np.flatnonzero(near)


def _mean_edges(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Return the mean length (n,) of the tets' edges at each node, 0 without any."""
    ends = tet_edges(tets)
    length = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    times = np.bincount(ends.ravel(), minlength=len(points))
    return np.bincount(ends.ravel(), np.repeat(length, 2), len(points)) / np.maximum(times, 1)


def _repaired(model: Model, grains: np.ndarray, aim: Aim | None) -> Model:
    """Return the model with the worst tets of `grains` by an aim repaired, the surface as it is."""
    measure = None if aim is None else aim.measure
    result = list(model.grain_tets)
    surfaces = {one.grain: one for one in grain_surfaces(model.surface, grains)}
    for i, one in enumerate(model.grain_tets):
        if one.grain not in surfaces:
            continue
        surface = surfaces[one.grain]
        points = np.concatenate([model.surface.points[one.nodes], one.interior])
        size = LocalSizing(surface.points, surface.facets).at(points)
        internal = np.searchsorted(one.nodes, surface.nodes[surface.facets[surface.internal]])
        points, tets = repaired_tets(points, one.tets, len(one.nodes), internal, size, measure)
        result[i] = GrainTets(one.grain, one.nodes, points[len(one.nodes) :], tets)
    return Model(model.surface, result)
