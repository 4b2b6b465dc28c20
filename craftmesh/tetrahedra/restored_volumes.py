"""Volumes of grains and voids restored after moves of the surface, without worse tetrahedra."""

from collections.abc import Mapping

import numpy as np

from craftmesh.surface.connectivity import corners_of, lowest_equal_point, touching, unique_edges
from craftmesh.surface.measure import mean_edges, volumes_of, worst_drift
from craftmesh.surface.volumes import restore_volumes
from craftmesh.tetrahedra.kernels.tet_objective import SOUND_FROM
from craftmesh.tetrahedra.kernels.tet_quality import COMBINED_QUALITY, all_qualities
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import Surface

# Relative change of a volume above which all are restored; the default of gradate.volume_tolerance.
TOLERATED = 0.02
# Largest move, relative to the mean length of the edges at the point. Largest drifts of 2.3 to 6.8 % in 14
# decks fell to 0.13 % or less.
REACH = 0.1


def with_volumes(model: Model, wanted: Mapping[int, float]) -> Model:
    """Return the model with all its volumes moved towards `wanted` if one is more than TOLERATED off.

    wanted: volumes by label, -k for void k. Surface points off the crack move by up to REACH; coincident
    points stay. No tetrahedron falls below the quality SOUND_FROM, or below its own if that is less. The
    model is returned unchanged if the largest drift would not decrease.
    """
    surface = model.surface
    drift = worst_drift(wanted, volumes_of(surface))
    if drift <= TOLERATED:
        return model
    lowest = lowest_equal_point(surface.points)
    coincident = np.bincount(lowest, minlength=len(lowest))[lowest] > 1
    reach = REACH * mean_edges(surface.points, unique_edges(surface.facets)[0])
    floor = np.minimum(model.quality, SOUND_FROM)

    def guarded(now: Surface, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the points (n, 3) moved to `places`, and a mask (n,) of points that are held instead."""
        held = coincident.copy()
        while True:
            moved = np.where(held[:, None], now.points, places)
            rows, quality = _qualities(model, moved)
            bad = corners_of(model.tets[rows], len(model.points), quality < floor[rows])[: len(held)]
            if not bad.any():
                return moved, held
            held |= bad

    targets = {label: volume for label, volume in wanted.items() if volume > 0}
    restored, _ = restore_volumes(surface, targets, guarded, reach=reach)
    if worst_drift(wanted, volumes_of(restored)) >= drift:
        return model
    rows, quality = _qualities(model, restored.points)
    qualities = model.quality.copy()
    qualities[rows] = quality
    return model.moved(_with_surface(model, restored.points), qualities)


def _with_surface(model: Model, points: np.ndarray) -> np.ndarray:
    """Return the model's points (n, 3) with its surface points at `points`."""
    return np.concatenate([points, model.points[len(points) :]])


def _qualities(model: Model, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and qualities (k,) of the tets that change if the surface moves to points (n, 3)."""
    moved = _with_surface(model, points)
    rows = np.flatnonzero(touching(model.tets, (moved != model.points).any(axis=1)))
    quality = np.empty(len(rows))
    all_qualities(moved, model.tets[rows], len(rows), quality, COMBINED_QUALITY)
    return rows, quality
