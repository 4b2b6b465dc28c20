"""Optimisation of the whole mesh: the surface slides, grains are optimised on it, and it slides again."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from craftmesh.mesh.shape_measures import shape_measures
from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.classification import IN_PATCH, ON_LINE, Classification
from craftmesh.surface.connectivity import lowest_equal_point, unique_edges
from craftmesh.surface.measure import area_vectors, mean_edges
from craftmesh.tetrahedra.kernels.tet_cavity import EDGES, POINTS, TETS, TetState, new_scratch
from craftmesh.tetrahedra.kernels.tet_objective import RATIOS, Aim
from craftmesh.tetrahedra.kernels.tet_passes import aspect_pass
from craftmesh.tetrahedra.kernels.tet_quality import POOR, WHOLE, all_aspect_ratios, all_qualities
from craftmesh.tetrahedra.kernels.tet_smoothing import FREE_FROM, smooth_on_surface
from craftmesh.tetrahedra.opening_model import weighed_faults
from craftmesh.tetrahedra.optimise_tets import resumed_tets
from craftmesh.tetrahedra.record import poor_by_grain
from craftmesh.tetrahedra.tet_state import new_state
from craftmesh.tetrahedra.whole_mesh import Model, changed_inside
from craftmesh.types import GrainTets, Surface

# Of sliding, before the grains are optimised and after. A third lowers the mean aspect ratio by .0005.
ROUNDS = 2
# Of the mean edge at a point: how far it may go.
REACH = 0.3
# Degrees: a point slides where its facets, or its line's edges, are this little off their mean. Where all
# points slide, small grains change by several percent.
BEND = 15.0


@dataclass(frozen=True)
class Smoothed:
    """Surface and tets of all grains, with points of the surface moved within it.

    report: how many points, the largest move, the mean aspect ratio before and after; poor: the rows of
    `poor_tets` of all grains that have such tets.
    """

    surface: Surface
    grain_tets: Sequence[GrainTets]
    report: dict
    poor: dict[str, list[dict]] = field(default_factory=dict)


def smoothed_surface(surface: Surface, grain_tets: Sequence[GrainTets], inside: bool = True) -> Smoothed:
    """Return the surface and all grains' tets with a lower mean aspect ratio, and no tet at fault more.

    Points inside a patch slide along it, on the tangent plane where they are, those on lines along these,
    for all neighbours alike: those where lines end, of the crack, and where the surface is bent stay. Where
    one moves, the worst of the tets round it gets no worse than FREE_FROM, or than it was. After
    these the interior points joined to the surface move, if those `inside` are to.
    """
    # in one order, however the grains were meshed: the last bit of a mean depends on it
    model = Model(surface, sorted(grain_tets, key=lambda one: one.grain))
    points, tets = model.points, model.tets
    nodes, ways = _sliding(surface)
    edges = unique_edges(surface.facets.astype(np.int64))[0]
    lengths = mean_edges(surface.points, edges)[nodes]
    valence = np.bincount(tets.ravel(), minlength=len(points))[nodes]
    state = new_state(points, tets, capacity=1.0)
    count, work, ratio = int(state.counts[TETS]), new_scratch(), np.empty(len(tets))
    all_qualities(state.points, state.tets, count, state.quality, WHOLE)
    all_aspect_ratios(state.points, state.tets, count, ratio)
    before = float(ratio.mean())
    if inside:
        _hold_all_but_neighbours(state, len(surface.points))
    for _ in range(ROUNDS):
        smooth_on_surface(state, nodes, points[nodes], ways, lengths, REACH, valence, work)
        if inside:
            aspect_pass(state, Aim(RATIOS, WHOLE, FREE_FROM, 0.0, 0.0), work)
    all_aspect_ratios(state.points, state.tets, count, ratio)
    model = model.moved(state.points[: len(points)])
    moves = np.linalg.norm(model.surface.points - surface.points, axis=1)
    report = {
        "surface_points_moved": int((moves > 0).sum()),
        "largest_move": float(moves.max(initial=0.0)),
        "aspect_ratio_mean": [before, float(ratio.mean())],
    }
    poor = np.unique(model.grain[state.quality[:count] < POOR])
    return Smoothed(
        model.surface, model.grain_tets, report, poor_by_grain(model.surface, model.grain_tets, poor)
    )


def _hold_all_but_neighbours(state: TetState, on_surface: int) -> None:
    """Freeze all but interior points joined to the surface; their sizes are the mean edge at them.

    Points of tets that are at fault, or nearly, stay: others round them might get worse.
    """
    count, points = int(state.counts[TETS]), int(state.counts[POINTS])
    tets = state.tets[:count]
    beside = tets[tets.min(axis=1) < on_surface]
    free = np.zeros(points, bool)
    free[beside] = True
    free[:on_surface] = False
    free[tets[state.quality[:count] < FREE_FROM]] = False
    state.frozen[:points] = ~free
    total = np.zeros(points)
    for ends in beside[:, EDGES].swapaxes(0, 1):
        length = np.linalg.norm(state.points[ends[:, 1]] - state.points[ends[:, 0]], axis=1)
        total += np.bincount(ends.ravel(), np.repeat(length, 2), points)
    state.size[:points] = total / np.maximum(3 * np.bincount(beside.ravel(), minlength=points), 1)


def _sliding(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (k,) that may slide, and two directions (k, 2, 3) for each.

    These have unit length; the second is zero on a line. A point of the box's faces slides within its face,
    exactly.
    """
    classes = Classification(surface)
    may = (classes.rank <= ON_LINE) & ~classes.on_crack
    lowest = lowest_equal_point(surface.points)
    may &= np.bincount(lowest, minlength=len(lowest))[lowest] == 1
    may &= np.bincount(surface.facets.ravel(), minlength=len(may)) > 0
    in_patch, on_line = (np.flatnonzero(may & (classes.rank == rank)) for rank in (IN_PATCH, ON_LINE))
    parts, ways = np.linalg.eigh(_normal_products(surface)[in_patch])
    flat = parts[:, 2] > np.cos(np.radians(BEND)) ** 2 * parts.sum(axis=1)
    straight, along = _line_directions(surface.points, classes, on_line)
    nodes = np.concatenate([in_patch[flat], on_line[straight]])
    ways = np.concatenate([np.swapaxes(ways[flat][:, :, :2], 1, 2), along[straight]])
    ways[np.repeat(classes.held[nodes][:, None], 2, axis=1)] = 0.0
    return nodes, np.ascontiguousarray(ways)


def _line_directions(
    points: np.ndarray, classes: Classification, nodes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return at which points (k,) their lines are all but straight, and ways (k, 2, 3) along these."""
    lines = classes.features.lines
    tail, head = np.concatenate([lines, lines[:, ::-1]]).T
    order = np.argsort(tail, kind="stable")
    first = np.searchsorted(tail[order], nodes)
    arms = points[head[order][first[:, None] + [0, 1]]] - points[nodes][:, None]
    way = arms[:, 1] - arms[:, 0]
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), np.finfo(float).tiny)
    cosine = np.abs(np.einsum("ijk,ik->ij", arms, way)) / np.linalg.norm(arms, axis=2)
    straight = (cosine > np.cos(np.radians(BEND))).all(axis=1)
    return straight, np.stack([way, np.zeros_like(way)], axis=1)


def _normal_products(surface: Surface) -> np.ndarray:
    """Return at each point (n, 3, 3) the products of its facets' unit normals, summed by area."""
    vectors = area_vectors(surface.points, surface.facets)
    size = np.maximum(np.linalg.norm(vectors, axis=1), np.finfo(float).tiny)
    products = vectors[:, :, None] * vectors[:, None, :] / size[:, None, None]
    result = np.zeros((len(surface.points), 3, 3))
    for k in range(3):
        np.add.at(result, surface.facets[:, k], products)
    return result


def optimised_whole(surface: Surface, grain_tets: Sequence[GrainTets]) -> Smoothed:
    """Return the surface and all grains' tets with a lower mean aspect ratio, and no grain at fault more.

    What slides and what stays: see `smoothed_surface`. Moves and the mean of the report are those of both
    times together.
    """
    first = smoothed_surface(surface, grain_tets, inside=False)
    model = changed_inside(Model(first.surface, first.grain_tets), surface.grains, _resumed)
    last = smoothed_surface(model.surface, model.grain_tets)
    moves = np.linalg.norm(last.surface.points - surface.points, axis=1)
    means = [smoothed.report["aspect_ratio_mean"] for smoothed in (first, last)]
    report = {
        "surface_points_moved": int((moves > 0).sum()),
        "largest_move": float(moves.max(initial=0.0)),
        "aspect_ratio_mean": [means[0][0], means[1][1]],
    }
    return replace(last, report=report)


def _resumed(
    points: np.ndarray, tets: np.ndarray, frozen: int, internal: np.ndarray, sizing: Lengths
) -> tuple[np.ndarray, np.ndarray]:
    """Return the points and tets of a grain optimised, or as they are where these are worth more."""
    found = resumed_tets(points, tets, frozen, internal, sizing)
    faults = weighed_faults(shape_measures(*found))
    is_worse = faults > 0 and faults > weighed_faults(shape_measures(points, tets))
    return (points, tets) if is_worse else found
