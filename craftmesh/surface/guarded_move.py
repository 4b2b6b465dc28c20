"""One guarded move: points go to their targets, and those that would spoil a facet are held."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from craftmesh.surface.connectivity import touching
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.hinges import SHARP_COSINE, sharpest_cosines
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, spoiled_facets
from craftmesh.surface.patches import facets_beyond_box
from craftmesh.types import Surface


@dataclass(frozen=True)
class MoveBounds:
    """What a move may do to a facet; a facet that was worse before may stay as bad.

    turn: degrees by which its normal may turn. quality: least 4 sqrt(3) area / sum of squared edges. edge:
    least length of its edges in model units.
    No bound is an option: no facet passes a plane of the box, comes to intersect another, or makes a wedge
    under SHARP_WEDGE sharper.
    """

    turn: float = 60.0
    quality: float = 0.2
    edge: float = 0.0


# Voxel steps are smoothed away: their facets turn until they lie in the boundary.
SMOOTHING = MoveBounds(turn=180.0, quality=0.25, edge=0.05)
# A tied node's copies go to the middles of their fans, whatever comes of the facets: cleaning follows.
RELEASING = MoveBounds(turn=180.0, quality=0.0)
# Where a point has to settle on a crack, a chord of which it leaves otherwise.
SETTLING = MoveBounds(turn=80.0, quality=0.02)
# No facet of a gradated surface gets worse that is under 15.7 degrees as a needle, or over 135 as a cap.
# With 0.2 facets of 10 degrees were left where the tolerances are wide.
RESTORING = MoveBounds(quality=0.45)
# Tries that hold the farthest point of each bad facet alone; then all its points are, then rings around.
PATIENCE = 3


def guarded_move(
    surface: Surface,
    targets: np.ndarray | Callable[[np.ndarray], np.ndarray],
    bounds: MoveBounds,
    spoils: Callable[[np.ndarray], np.ndarray] | None = None,
    known: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (n, 3) moved within the bounds, and (n,) bool the points that were held for them.

    targets (n, 3): the places that points go to; or a function of the held points (n,) bool that returns
    them, with held points where they were. Neighbours of a held point then follow it, so that they are held
    too, from the first try. spoils: returns further bad facets (m,) of moved points. known (k, 2): pairs of
    facets that may intersect; None: those that do. Points of bad facets are held, and the rest tried again.
    """
    points, facets = surface.points, surface.facets.astype(np.int64)
    held, last = np.zeros(len(points), bool), points
    rings = -PATIENCE if isinstance(targets, np.ndarray) else 1
    while True:
        moved = targets(held) if callable(targets) else np.where(held[:, None], points, targets)
        changed = touching(facets, (moved != last).any(axis=1))
        bad = np.zeros(len(facets), bool) if spoils is None else spoils(moved)
        rows = np.flatnonzero(changed)
        bad[rows] |= _spoiled(surface, facets, moved, bounds, rows)
        pairs = intersecting_pairs(moved, facets, chosen=changed)
        if len(pairs):
            known = intersecting_pairs(points, facets) if known is None else known
            stride = np.array([len(facets), 1])
            is_moved = touching(facets, (moved != points).any(axis=1))
            bad[pairs[~np.isin(pairs @ stride, known @ stride) & is_moved[pairs].any(axis=1)]] = True
        newly = _to_hold(facets, bad, rings, np.linalg.norm(moved - points, axis=1)) & ~held
        if not newly.any():
            return moved, held
        held, last, rings = held | newly, moved, rings + 1


def _spoiled(
    surface: Surface, facets: np.ndarray, moved: np.ndarray, bounds: MoveBounds, rows: np.ndarray
) -> np.ndarray:
    """Return (k,) bool: the facets `rows` that moved points put out of their bounds, one by one."""
    points, chosen = surface.points, facets[rows]
    bad = spoiled_facets(moved, points, chosen, bounds.quality, bounds.edge)
    bad |= facets_beyond_box(moved, points, chosen, surface.kind[rows])
    before, after = area_vectors(points, chosen), area_vectors(moved, chosen)
    size = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    bad |= np.einsum("ij,ij->i", before, after) < np.cos(np.radians(bounds.turn)) * size
    cosine = _sharpest(moved, facets, rows)
    sharp = np.flatnonzero(cosine > SHARP_COSINE)
    bad[sharp] |= cosine[sharp] > _sharpest(points, facets, rows[sharp])
    return bad


def _sharpest(points: np.ndarray, facets: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the largest cosine (k,) between each of the facets `rows` and those at its edges."""
    near = np.zeros(len(points), bool)
    near[facets[rows]] = True
    around = np.flatnonzero(near[facets].sum(axis=1) > 1)
    cosines = sharpest_cosines(points, facets[around], *corner_lists(facets[around], len(points)))
    return cosines[np.searchsorted(around, rows)]


def _to_hold(facets: np.ndarray, bad: np.ndarray, rings: int, step: np.ndarray) -> np.ndarray:
    """Return (n,) bool: who is held for bad facets (m,): the farthest of each, or all and rings."""
    if rings >= 0:
        return vertices_around(facets, bad, rings, len(step))
    hold = np.zeros(len(step), bool)
    farthest = step[facets[bad]].argmax(axis=1)
    hold[np.take_along_axis(facets[bad], farthest[:, None], axis=1)] = True
    return hold & (step > 0)


def vertices_around(facets: np.ndarray, chosen: np.ndarray, rings: int, n_points: int) -> np.ndarray:
    """Return (n_points,) bool: vertices of the chosen facets and of `rings` rings of facets around them."""
    around = np.zeros(n_points, bool)
    around[facets[chosen]] = True
    for _ in range(rings):
        around[facets[touching(facets, around)]] = True
    return around
