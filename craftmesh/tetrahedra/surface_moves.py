"""Surface moves for all grains at once: along the surface, and off the surface at faulty tets.

Faulty tets are flat, poor (bad dihedral angles or shape factor), stretched (aspect ratio over STRETCHED) or
narrow (under WIDE by the measure SHAPE_QUALITY).
"""

from dataclasses import dataclass

import numpy as np

from craftmesh.mesh.shape_measures import is_flat, is_poor, shape_measures
from craftmesh.surface.connectivity import (
    compact,
    corners_of,
    layers_around,
    lowest_equal_point,
)
from craftmesh.surface.measure import area_vectors, numbered, volumes_of, worst_drift
from craftmesh.tetrahedra.kernels.tet_cavity import POINTS, TETS, TetState, hold_pinched, new_scratch
from craftmesh.tetrahedra.kernels.tet_means import mean_edges
from craftmesh.tetrahedra.kernels.tet_objective import SOUND_FROM
from craftmesh.tetrahedra.kernels.tet_quality import (
    COMBINED_QUALITY,
    POOR,
    SHAPE_QUALITY,
    STRETCHED,
    WIDE,
    all_aspect_ratios,
    all_qualities,
)
from craftmesh.tetrahedra.kernels.tet_smoothing import FREE_FROM
from craftmesh.tetrahedra.optimise_tets import FORMED, LIGHTEN, SOUNDER, Step, do_steps
from craftmesh.tetrahedra.restored_volumes import TOLERATED, with_volumes
from craftmesh.tetrahedra.surface_freedom import along_surface, off_surface
from craftmesh.tetrahedra.tet_state import Bounds, new_state, unlinked_state
from craftmesh.tetrahedra.whole_mesh import Model, regrouped
from craftmesh.types import Surface

# Moves along the surface: two passes, because a third one would lower the mean aspect ratio by only .0005.
SLIDING = 2 * (Step("aspect", FREE_FROM, COMBINED_QUALITY),)
# Largest moves off the surface, relative to the mean length of the edges at the point, in successive rounds
# while tets are faulty, so that small moves are tried before large ones. On random cracks, 0.15 as the last
# of these leaves several times as many stretched tets as 0.4.
REACHES = (0.025, 0.05, 0.1, 0.2, 0.4)
# The last of these rounds in which tets that are only narrow (under WIDE by SHAPE_QUALITY) are worked on.
NARROW_REACH = 0.1
# Largest estimated relative volume change of grains and voids; it does not bound points at flat and poor
# tets.
MOST_DRIFT = 0.05
# Layers of tets around faulty tets within which the mesh may change.
LAYERS = 4


def is_stretched(measures: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of tets with an aspect ratio over STRETCHED, from `shape_measures` (m, 5)."""
    return measures[:, 1] > STRETCHED


def slid(model: Model) -> tuple[Model, dict]:
    """Return the model after moves along the surface that lower the mean aspect ratio, and a report.

    Surface points move within the bounds of `along_surface`; interior points of tets with a surface point
    move too. Points of poor and stretched tets stay. A move takes no quality below FREE_FROM, or below the
    worst quality at the point if that is less. The report has the number of surface points moved, their
    largest move, and the mean aspect ratio before and after.
    """
    bounds, tets = along_surface(model.surface), model.tets
    on_surface = len(bounds.reach)
    may = corners_of(tets, len(model.points), tets.min(axis=1) < on_surface)
    may[:on_surface] = bounds.ways.any(axis=(1, 2))
    may[tets[model.quality < SOUND_FROM]] = False
    size = np.empty(len(may))
    mean_edges(model.points, tets, size, np.empty(len(may), np.int64))
    state = unlinked_state(model.points.copy(), tets, size, ~may, model.quality.copy(), bounds)
    do_steps(state, SLIDING, new_scratch(), COMBINED_QUALITY)
    found = model.moved(state.points, state.quality)
    moves = np.linalg.norm(found.surface.points - model.surface.points, axis=1)
    return found, {
        "surface_points_moved": int((moves > 0).sum()),
        "largest_move": float(moves.max(initial=0.0)),
        "aspect_ratio_mean": [_mean_ratio(one) for one in (model, found)],
    }


def _mean_ratio(model: Model) -> float:
    ratio = np.empty(len(model.tets))
    all_aspect_ratios(model.points, model.tets, len(ratio), ratio)
    return float(ratio.mean())


def _state_near(
    model: Model,
    rows: np.ndarray,
    bounds: Bounds,
    facets: np.ndarray,
) -> tuple[TetState, np.ndarray]:
    """Return the optimiser's state of the model's tets `rows` (k,), and the model's ids (n,) of its points.

    Frozen are points that other tets use too, surface points that may not move (`bounds`), and surface
    points whose tets are not connected over faces. facets (m, 3): surface facets, which no cavity crosses.
    Target lengths are the mean edge lengths at points.
    """
    points, tets = model.points, model.tets
    near, local, used = compact(points, tets[rows])
    own = used[used < len(bounds.reach)]
    inner = np.searchsorted(own, facets[np.isin(facets, own).all(axis=1)])
    size = np.empty(len(used))
    mean_edges(near, local, size, np.empty(len(used), np.int64))
    bounds = Bounds(*(part[own] for part in bounds))
    state = new_state(near, local, 0, inner, size, bounds, model.grain[rows])
    valence = np.bincount(tets.ravel(), minlength=len(points))[used]
    state.frozen[: len(used)] = valence != np.bincount(local.ravel(), minlength=len(used))
    state.frozen[: len(own)] |= ~state.ways[: len(own)].any(axis=(1, 2))
    hold_pinched(state, valence[: len(own)], new_scratch())
    return state, used


@dataclass(frozen=True)
class GivenWay:
    """The model after moves off the surface at faulty tets.

    report: counts of flat, poor and stretched tets before and after, and moves, None without faulty tets;
    warning: a line about moves at poor tets, None if there were none.
    """

    model: Model
    report: dict | None = None
    warning: str | None = None


def given_way(model: Model) -> GivenWay:
    """Return the model with fewer flat, poor, stretched and narrow tets; without any it is unchanged.

    Within LAYERS layers of tets around faulty tets, interior nodes move and sets of tets are replaced to
    lower the fault weight, a penalty on these tets. Surface nodes next to faulty tets move off the surface
    by up to 0.4 times the mean length of their edges, within the bounds of `off_surface`. If these moves
    change a volume by more than TOLERATED, all volumes are restored (`restored_volumes`).
    """
    points, tets, facets = model.points, model.tets, model.surface.facets
    quality, bad = model.quality, model.quality < SOUND_FROM
    rows = np.flatnonzero(~bad & (quality < FREE_FROM))
    form = np.empty(len(rows))
    all_qualities(points, tets[rows], len(rows), form, SHAPE_QUALITY)
    bad[rows] = form < WIDE
    if not bad.any():
        return GivenWay(model)
    rows = np.flatnonzero(layers_around(tets, len(points), bad, LAYERS))
    bounds = off_surface(model.surface)
    facets = lowest_equal_point(model.surface.points)[facets]
    state, used = _state_near(model, rows, bounds, facets)
    own = used[used < len(bounds.reach)]
    near = corners_of(tets, len(points), layers_around(tets, len(points), bad, 1))[own]
    poor = corners_of(tets, len(points), layers_around(tets, len(points), quality < POOR, 1))[own]
    state.frozen[: len(own)] |= ~near
    length = state.size[: len(own)]
    before = shape_measures(points, tets[rows])
    free = np.where(state.frozen[: len(own)], 0.0, length)
    most = REACHES[-1] * np.where(poor, 1.0, _share(model.surface, facets, own, free * REACHES[-1]))
    work = new_scratch()
    for reach in REACHES:
        state.reach[:-1] = np.minimum(bounds.reach[own], np.minimum(reach, most) * length)
        do_steps(state, (FORMED, SOUNDER, LIGHTEN) if reach <= NARROW_REACH else (SOUNDER, LIGHTEN), work)
        count = int(state.counts[TETS])
        live = state.tets[:count, 0] >= 0
        if reach >= NARROW_REACH and (state.quality[:count][live] >= SOUND_FROM).all():
            break
    live = np.flatnonzero(state.tets[: state.counts[TETS], 0] >= 0)
    made = state.points[len(used) : state.counts[POINTS]]
    ids = np.concatenate([used, len(points) + np.arange(len(made))])
    moved = points.copy()
    moved[used] = state.points[: len(used)]
    found = regrouped(
        model.moved(moved, quality),
        rows,
        np.concatenate([moved, made]),
        ids[state.tets[live]],
        state.label[live],
        state.quality[live],
    )
    found = with_volumes(found, volumes_of(model.surface))
    report = _report(model, found, before, shape_measures(state.points, state.tets[live]))
    return GivenWay(found, report, _warning(report))


def _share(surface: Surface, facets: np.ndarray, own: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Return the fraction (k,) of its reach that each point may move.

    own (k,): the points; reach (k,): their largest moves. The estimated volume change of each grain and
    void stays under MOST_DRIFT; the estimate takes inward and outward moves as equally likely.
    """
    swept = np.zeros(len(surface.points))
    swept[own] = reach
    area = np.linalg.norm(area_vectors(surface.points, facets), axis=1)
    labels, side = numbered(surface.sides)
    across = side[:, 0] != side[:, 1]
    square = (area * swept[facets].sum(axis=1) / 3)[across] ** 2
    change = np.sqrt(sum(np.bincount(s[across], square, len(labels)) for s in side.T))
    volume = volumes_of(surface)
    most = MOST_DRIFT * np.array([abs(volume.get(int(k), np.inf)) for k in labels])
    part = np.minimum(1.0, most / np.maximum(change, 1e-300))
    result = np.ones(len(surface.points))
    np.minimum.at(result, facets[across], part[side[across]].min(axis=1)[:, None])
    return result[own]


def _report(model: Model, found: Model, before: np.ndarray, after: np.ndarray) -> dict:
    surface = found.surface
    moves = np.linalg.norm(surface.points - model.surface.points, axis=1)
    counts = {
        f"{name}_{when}": int(is_bad(measures).sum())
        for name, is_bad in (("flat", is_flat), ("poor", is_poor), ("stretched", is_stretched))
        for when, measures in (("before", before), ("left", after))
    }
    return counts | {
        "surface_points_moved": int((moves > 0).sum()),
        "largest_move": float(moves.max()),
        "volume_drift_worst": worst_drift(volumes_of(model.surface), volumes_of(found.surface)),
    }


def _warning(report: dict) -> str | None:
    drifts = report["volume_drift_worst"] > TOLERATED
    if not (report["poor_before"] and report["surface_points_moved"]) and not drifts:
        return None
    return (
        f"{report['poor_before']} poor tetrahedra, {report['flat_before']} of them flat, lie where the "
        f"surface leaves no room for good ones: {report['surface_points_moved']} surface points were "
        f"moved, in all their grains, by up to {report['largest_move']:.3g}; {report['poor_left']} poor "
        f"and {report['flat_left']} flat tetrahedra are left, the largest change of a grain's volume is "
        f"{100 * report['volume_drift_worst']:.2g} %"
    )
