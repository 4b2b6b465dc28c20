"""Which tetrahedra a new crack and new target lengths change."""

import numpy as np
import scipy

from craftmesh.cracks.crack_tolerances import PROMISED
from craftmesh.renewal.whole import Whole
from craftmesh.sizing.sizing import Sizing, densify
from craftmesh.surface.connectivity import corners_of, joined, layers_around, touching
from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.labels import labels_at
from craftmesh.surface.measure import nearest_facet
from craftmesh.types import CRACK, Crack, Surface

# Relative changes of the target length: nodes with a larger change than CHANGED are renewed, and with them
# nodes with a larger change than TOUCHED that edges connect to them. The gradation leaves edges of 0.75 to
# 1.4 target lengths, so elements still fit after a change of 30 %. Without TOUCHED, regions to renew would
# be so thin that their elements could not become coarser.
CHANGED, TOUCHED = 0.3, 0.15
# Distance, in l_min, within which nodes are renewed: from new parts of the crack, from parts that no longer
# belong to it, and from the old and the new front.
MARGIN = 4.0
# Layers of old tetrahedra around the new ones that are optimised together with these.
RIM = 2
# Distance from the old crack's facets, in l_min, beyond which a part of the crack counts as new.
BEYOND = 0.5


def changed_tets(whole: Whole, crack: Crack, sizing: Sizing) -> np.ndarray:
    """Return a mask (m,) of the tets to renew for a crack and target lengths.

    Tets near the new part of the crack in the grains, near parts of the old crack that are off the new one,
    and near both fronts are renewed, and tets where the target length has changed; none if all of these are
    as before within their tolerances. Gaps of up to four RIMs between them are renewed, too, because
    small pieces that stay leave poor shapes.
    """
    points, surface = whole.points, whole.surface
    old = surface.facets[surface.kind == CRACK].astype(np.int64)
    ends = surface.points[np.unique(front_edges(surface))]
    fronts = [densify(crack.points[front], sizing.l_min) for front in crack.fronts]
    samples = samples_of(crack, sizing.l_min)
    left = np.zeros((0, 3))
    if len(old):
        away = nearest_facet(samples, surface.points, old)[1]
        samples, left = samples[away > BEYOND * sizing.l_min], surface.points[np.unique(old)]
        off = nearest_facet(left, crack.points, crack.triangles.astype(np.int64))[1]
        left = left[off > PROMISED.facets * sizing.l_min]
    label = labels_at(samples, surface.points, surface.facets, surface.sides)
    marks = np.concatenate([samples[label > 0], left])
    length = sizing.at(points)
    change = np.abs(length / whole.lengths - 1)
    if not (len(marks) or (change > CHANGED).any() or _fronts_moved(surface, crack, fronts, sizing.l_min)):
        return np.zeros(len(whole.tets), bool)
    tree = scipy.spatial.cKDTree(np.concatenate([ends, *fronts, marks]))
    near = np.isfinite(tree.query(points, distance_upper_bound=MARGIN * sizing.l_min)[0])
    chosen = touching(whole.tets, _with_joined(whole, near | (change > CHANGED), change))
    around = layers_around(whole.tets, len(points), chosen, 2 * RIM)
    return _closed(whole, chosen | ~layers_around(whole.tets, len(points), ~around, 2 * RIM))


def _fronts_moved(surface: Surface, crack: Crack, samples: list[np.ndarray], l_min: float) -> bool:
    """Return whether the fronts in a surface and those of a crack are farther apart than is promised.

    The promise is PROMISED.front, in l_min. samples: points (k, 3) on each front of the crack, which may be
    twice as far from the surface's fronts, because edges between nodes may be, too.
    """
    before = front_edges(surface)
    if not len(before) or not samples:
        return len(before) + len(samples) > 0
    now = np.concatenate([np.stack([front[:-1], front[1:]], axis=1) for front in crack.fronts])
    nodes, between = surface.points[np.unique(before)], np.concatenate(samples)
    off = np.linalg.norm(nearest_on_edges(nodes, crack.points, now) - nodes, axis=1)
    away = np.linalg.norm(nearest_on_edges(between, surface.points, before) - between, axis=1)
    return bool(max(off.max(), away.max() / 2) > PROMISED.front * l_min)


def samples_of(crack: Crack, spacing: float) -> np.ndarray:
    """Return points (k, 3) that sample the crack's triangles evenly, corners included.

    spacing: the largest distance between successive samples on an edge of a triangle.
    """
    corners = crack.points[crack.triangles]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    parts = np.maximum(np.ceil(longest / spacing), 1).astype(np.int64)
    found = [np.zeros((0, 3))]
    for n in np.unique(parts).tolist():
        i, j = np.nonzero(np.add.outer(np.arange(n + 1), np.arange(n + 1)) <= n)
        share = np.stack([i, j, n - i - j], axis=1) / n
        found.append(np.einsum("sk,tkd->tsd", share, corners[parts == n]).reshape(-1, 3))
    return np.concatenate(found)


def widened(whole: Whole, chosen: np.ndarray, layers: int = RIM) -> np.ndarray:
    """Return a mask (m,) of the tets in `chosen` (m,), of `layers` of tets around them, and of more.

    Tets that have a crack or void facet in common with these are added, with all tets at such a void.
    """
    return _closed(whole, layers_around(whole.tets, len(whole.points), chosen, layers))


def _with_joined(whole: Whole, changed: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of the changed nodes, and of nodes over TOUCHED that chains of edges join to them.

    changed (n,): mask; change (n,): relative change of the target length. All nodes of the chains must be
    changed or over TOUCHED.
    """
    may = changed | (change > TOUCHED)
    inside = may[whole.tets]
    ends = [np.zeros((2, 0), np.int64)]
    for a, b in zip(*np.triu_indices(4, 1)):
        ends.append(whole.tets[inside[:, a] & inside[:, b]][:, [a, b]].T)
    piece = joined(len(may), *np.concatenate(ends, axis=1))
    has = np.zeros(int(piece.max()) + 1, bool)
    has[piece[changed]] = True
    return may & has[piece]


def _closed(whole: Whole, chosen: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of the chosen tets and of all that have a crack or void facet in common with them.

    Voids count as a whole, because their boundaries have to be closed.
    """
    surface = whole.surface
    least = surface.sides.min(axis=1)
    together = (surface.kind == CRACK) | (least < 0)
    facets, void = surface.facets[together], np.minimum(least[together], 0)
    while len(facets):
        has = corners_of(whole.tets, len(whole.points), chosen)[facets].all(axis=1)
        has |= (void < 0) & np.isin(void, void[has])
        on = corners_of(facets, len(whole.points), has)
        more = chosen | (on[whole.tets].sum(axis=1) >= 3)
        if np.array_equal(more, chosen):
            break
        chosen = more
    return chosen
