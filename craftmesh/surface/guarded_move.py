"""Move points to their targets, except points whose move would make a facet invalid or degraded."""

from collections.abc import Callable
from dataclasses import astuple, dataclass

import numpy as np

from craftmesh.surface.connectivity import touching
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.spoiled import spoiled
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.patches import box_levels
from craftmesh.types import Surface


@dataclass(frozen=True)
class MoveBounds:
    """Bounds on what a move may do to a facet; a facet that was worse before may stay as bad.

    turn: largest turn of its normal in degrees. quality: smallest 4 sqrt(3) area / sum of squared edges.
    edge: smallest length of its edges in model units. Three further bounds are fixed: no facet passes a box
    plane, intersects another one, or makes a wedge below SHARP_WEDGE sharper.
    """

    turn: float = 60.0
    quality: float = 0.2
    edge: float = 0.0


# Bounds for smoothing voxel steps: their facets may turn until they lie in the boundary.
SMOOTHING = MoveBounds(turn=180.0, quality=0.25, edge=0.05)
# Bounds for the copies of a split non-manifold vertex. Each moves among its own facets; cleaning follows.
RELEASING = MoveBounds(turn=180.0, quality=0.0)
# Bounds for a point that must move onto a crack, because the crack would be cut along a chord otherwise.
SETTLING = MoveBounds(turn=80.0, quality=0.02)
# Bounds for a gradated surface: a needle below 15.7 degrees or a cap above 135 gets no worse. With a
# quality of 0.2, facets of 10 degrees were left where the tolerances are wide.
RESTORING = MoveBounds(quality=0.45)
# Number of first attempts that hold only the farthest-moving point of each bad facet; later attempts hold
# all its points, then rings of facets around it.
PATIENCE = 3


def guarded_move(
    surface: Surface,
    targets: np.ndarray | Callable[[np.ndarray], np.ndarray],
    bounds: MoveBounds,
    spoils: Callable[[np.ndarray], np.ndarray] | None = None,
    known: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (n, 3) moved within the bounds, and a mask (n,) of points that were held.

    Points of facets that the move would make bad are held, and the move is tried again until no facet is
    bad. targets (n, 3): new positions; or a function that returns them for the held points' mask (n,) and
    leaves held points in place. With a function, a bad facet's neighbours are held from the first attempt,
    because their targets follow held points. spoils: function that returns a mask (m,) of further bad
    facets for moved points (n, 3). known (k, 2): pairs of facets that may intersect; None: pairs that
    already do.
    """
    points, facets = np.array(surface.points), np.array(surface.facets)  # kernels take no read-only ones
    lists, levels = corner_lists(facets, len(points)), box_levels(surface)
    held, last = np.zeros(len(points), bool), points
    rings = -PATIENCE if isinstance(targets, np.ndarray) else 1
    while True:
        moved = targets(held) if callable(targets) else np.where(held[:, None], points, targets)
        changed = touching(facets, (moved != last).any(axis=1))
        bad = spoiled(points, moved, facets, lists, changed, levels, astuple(bounds))
        # Held facets are bad only by a wedge with a neighbour that moves, which may not have changed since.
        held_still = bad & held[facets].all(axis=1)
        bad |= touching(facets, vertices_around(facets, held_still, 0, len(points)))
        if spoils is not None:
            bad |= spoils(moved)
        pairs = intersecting_pairs(moved, facets, chosen=changed)
        if len(pairs):
            is_moved = touching(facets, (moved != points).any(axis=1))
            bad[pairs[is_moved[pairs].any(axis=1) & ~_among(pairs, known, points, facets)]] = True
        newly = _to_hold(facets, bad, rings, moved - points) & ~held
        if not newly.any():
            return moved, held
        held, last, rings = held | newly, moved, rings + 1


def _among(
    pairs: np.ndarray, known: np.ndarray | None, points: np.ndarray, facets: np.ndarray
) -> np.ndarray:
    """Return a mask (k,) of the pairs (k, 2) that are in `known`; None: that intersect before the move."""
    if known is None:
        rows = np.unique(pairs)
        known = rows[intersecting_pairs(points, facets[rows])]
    stride = np.array([len(facets), 1])
    return np.isin(pairs @ stride, known @ stride)


def _to_hold(facets: np.ndarray, bad: np.ndarray, rings: int, way: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of points to hold because of the facets in `bad` (m,); way (n, 3): the moves.

    If rings < 0, these are the farthest-moving points of the bad facets, one of each; else all their points
    and those of `rings` rings of facets around them.
    """
    if rings >= 0:
        return vertices_around(facets, bad, rings, len(way))
    hold, step = np.zeros(len(way), bool), np.linalg.norm(way, axis=1)
    farthest = step[facets[bad]].argmax(axis=1)
    hold[np.take_along_axis(facets[bad], farthest[:, None], axis=1)] = True
    return hold & (step > 0)


def vertices_around(facets: np.ndarray, chosen: np.ndarray, rings: int, n_points: int) -> np.ndarray:
    """Return a mask (n_points,) of vertices of the chosen facets and of `rings` rings around them."""
    around = np.zeros(n_points, bool)
    around[facets[chosen]] = True
    for _ in range(rings):
        around[facets[touching(facets, around)]] = True
    return around
