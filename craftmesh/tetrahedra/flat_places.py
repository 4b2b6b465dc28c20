"""Flat tets that a grain's own surface forces: the surface gives way, for both neighbours alike."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from craftmesh.mesh.kernels.shape_measures import shape_measures
from craftmesh.mesh.poor import is_flat
from craftmesh.mesh.tet_connectivity import tet_edges
from craftmesh.sizing.surface_sizing import LocalSizing
from craftmesh.surface.measure import side_volumes, volume_drift
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.kernels.tet_cavity import TETS, new_scratch
from craftmesh.tetrahedra.kernels.tet_quality import FORM, POOR, Aim, all_qualities
from craftmesh.tetrahedra.kernels.tet_surface_moves import move_nodes
from craftmesh.tetrahedra.optimise_tets import new_state, repaired_tets
from craftmesh.tetrahedra.poor_tets import poor_tets
from craftmesh.tetrahedra.surface_contractions import contracted
from craftmesh.tetrahedra.surface_freedom import freedom
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import GrainTets, Surface

# Nodes of the surface move by at most these parts of the mean edge at them, round by round, until no tet
# is flat: what a small move opens is not opened by a large one.
REACHES = (0.025, 0.05, 0.1, 0.2, 0.3, 0.4)
# Rounds of contractions: what one leaves may be contracted in the next.
CONTRACTIONS = 3
# Sweeps over the nodes near a flat tet in a round.
SWEEPS = 3


@dataclass(frozen=True)
class GivenWay:
    """Surface and tets of all grains after flat tets were opened.

    report: counts and the largest move, poor: the rows of `poor_tets` by grain where tets changed, warning:
    what was moved in one line; None and nothing where no tet was flat.
    """

    surface: Surface
    grain_tets: Sequence[GrainTets]
    report: dict | None = None
    poor: dict[str, list[dict]] = field(default_factory=dict)
    warning: str | None = None


def given_way(surface: Surface, grain_tets: Sequence[GrainTets]) -> GivenWay:
    """Return the surface and all grains' tets with fewer flat ones (`mesh/poor`).

    Nodes near flat tets go to where the worst tet round them, in any grain, is better; those of the surface
    by up to 0.4 of the mean edge at them, those of the box on its planes, those of a flat crack in its
    plane, those of other cracks and of fronts not at all. Where that is not enough, edges of the surface
    are contracted. After that the grains there are repaired inside. A function of the whole mesh, not of
    chunks.
    """
    model, homes = Model(surface, list(grain_tets)), surface.points
    flat = _flat(model)
    before, changed = int(flat.sum()), np.zeros(0, np.int64)
    if not before:
        return GivenWay(surface, grain_tets)
    free, count = freedom(surface), 0
    model, grains = _with_moves(model, homes, free)
    changed = np.union1d(changed, grains)
    for _ in range(CONTRACTIONS):
        flat = _flat(model)
        if not flat.any():
            break
        model, grains, done = contracted(model, flat)
        if not done:
            break
        model, seen = _with_moves(_repaired(model, grains), homes, free)
        changed, count = np.union1d(changed, np.union1d(grains, seen)), count + done
    report = _report(homes, model.surface, before, int(_flat(model).sum())) | {"edges_contracted": count}
    return GivenWay(model.surface, model.grain_tets, report, _poor(model, changed), _warning(report))


def _with_moves(model: Model, homes: np.ndarray, free: np.ndarray) -> tuple[Model, np.ndarray]:
    """Return the model with nodes near flat tets moved, further each round, and the grains that changed."""
    changed = np.zeros(0, np.int64)
    for reach in REACHES:
        flat = _flat(model)
        if not flat.any():
            break
        points, grains = _moved_points(model, homes, reach, free, flat)
        model, changed = _repaired(model.moved(points), grains), np.union1d(changed, grains)
    return model, changed


def _report(homes: np.ndarray, surface: Surface, before: int, left: int) -> dict:
    moves = np.linalg.norm(surface.points - homes, axis=1)
    volumes = [side_volumes(points, surface.facets, surface.sides) for points in (homes, surface.points)]
    drift = volume_drift(*volumes)
    return {
        "flat_before": before,
        "flat_left": left,
        "surface_points_moved": int((moves > 0).sum()),
        "largest_move": float(moves.max()),
        "volume_drift_worst": max(map(abs, drift.values()), default=0.0),
    }


def _warning(report: dict) -> str | None:
    if not report["surface_points_moved"] and not report["edges_contracted"]:
        return None
    return (
        f"{report['flat_before']} flat tetrahedra lie where the surface leaves no room: "
        f"{report['surface_points_moved']} of its points were moved by up to {report['largest_move']:.3g} "
        f"and {report['edges_contracted']} of its edges contracted, for both neighbours alike; "
        f"{report['flat_left']} are left and the largest change of a volume is "
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


def _flat(model: Model) -> np.ndarray:
    return is_flat(shape_measures(model.points, model.tets))


def _moved_points(
    model: Model, homes: np.ndarray, reach: float, free: np.ndarray, flat: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return all nodes, those near flat tets moved, and the grains that see a move.

    reach: the largest move of a surface point from its home, in mean edges; free (n, 3, 3): see `freedom`.
    """
    points, tets = model.points, model.tets
    nodes = _nodes_near(tets, flat, np.any(free != 0, axis=(1, 2)))
    rows = np.flatnonzero(np.isin(tets, nodes).any(axis=1))
    used, local = np.unique(tets[rows], return_inverse=True)
    state = new_state(points[used], local.reshape(-1, 4))
    all_qualities(state.points, state.tets, state.counts[TETS], state.quality, FORM)
    outer = nodes < len(homes)
    home, steps, part = points[nodes], np.repeat(np.eye(3)[None], len(nodes), axis=0), np.ones(len(nodes))
    home[outer], steps[outer], part[outer] = homes[nodes[outer]], free[nodes[outer]], reach
    furthest = part * _mean_edges(points, tets[rows])[nodes]
    valence = np.bincount(tets[rows].ravel(), minlength=len(points))[nodes]
    work, place = new_scratch(), np.searchsorted(used, nodes)
    for _ in range(SWEEPS):
        if not move_nodes(state, place, home, furthest, steps, valence, Aim(FORM, POOR), work):
            break
    moved = points.copy()
    moved[used] = state.points[: len(used)]
    changed = (moved != points).any(axis=1)
    return moved, np.unique(model.grain[changed[tets].any(axis=1)])


def _nodes_near(tets: np.ndarray, flat: np.ndarray, mobile: np.ndarray) -> np.ndarray:
    """Return the nodes of flat tets, and of those that share a node with them, that may move."""
    near = np.zeros(int(tets.max()) + 1, bool)
    near[tets[flat].ravel()] = True
    near[tets[near[tets].any(axis=1)].ravel()] = True
    near[: len(mobile)] &= mobile
    return np.flatnonzero(near)


def _mean_edges(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Return the mean length (n,) of the tets' edges at each node, 0 without any."""
    ends = tet_edges(tets)
    length = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    times = np.bincount(ends.ravel(), minlength=len(points))
    return np.bincount(ends.ravel(), np.repeat(length, 2), len(points)) / np.maximum(times, 1)


def _repaired(model: Model, grains: np.ndarray) -> Model:
    """Return the model with the poor tets of `grains` repaired, the surface as it is."""
    result = list(model.grain_tets)
    surfaces = {one.grain: one for one in grain_surfaces(model.surface, grains)}
    for i, one in enumerate(model.grain_tets):
        if one.grain not in surfaces:
            continue
        surface = surfaces[one.grain]
        points = np.concatenate([model.surface.points[one.nodes], one.interior])
        size = LocalSizing(surface.points, surface.facets).at(points)
        internal = np.searchsorted(one.nodes, surface.nodes[surface.facets[surface.internal]])
        points, tets = repaired_tets(points, one.tets, len(one.nodes), internal, size)
        result[i] = GrainTets(one.grain, one.nodes, points[len(one.nodes) :], tets)
    return Model(model.surface, result)
