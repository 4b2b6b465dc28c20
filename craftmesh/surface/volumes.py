"""Restore the volumes of grains: smallest displacement of a surface that corrects all volumes."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
import scipy

from craftmesh.arguments import LARGEST, as_array
from craftmesh.errors import CraftmeshError
from craftmesh.progress import silent
from craftmesh.surface.classification import Classification
from craftmesh.surface.guarded_move import MoveBounds, guarded_move
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.gradients import around_points, volume_gradients
from craftmesh.surface.measure import enclosed, shortened
from craftmesh.types import Surface

# Largest move of a vertex in one correction, relative to the mean length of its edges.
STEP = 0.3
# Relative error of the volumes from which on they are corrected, and most corrections.
TOLERANCE, VOLUME_CORRECTIONS = 5e-4, 8
# Regularisation, relative to the diagonal: the system is singular if the grains fill a box of fixed volume.
DAMPING = 1e-9

Move = Callable[[Surface, np.ndarray], tuple[np.ndarray, np.ndarray]]


def restore_volumes(
    surface: Surface,
    targets: Mapping[int, float],
    bounds: MoveBounds | Move | None = None,
    rounds: int = VOLUME_CORRECTIONS,
    reach: np.ndarray | float = np.inf,
    progress: Callable[[float, str], None] = silent,
) -> tuple[Surface, dict]:
    """Return the surface with its vertices moved so that each grain has its target volume, and a report.

    targets: volume in model units by grain id, or -k for void k. The displacement has the smallest
    area-weighted mean square that corrects all volumes to first order. It is repeated at most `rounds`
    times, until no volume is off by more than TOLERANCE; the report says what is left.
    Vertices stay on planes, edges and corners of the box, and within reach (n,) of their first positions;
    vertices of crack facets do not move. No facet breaks the `bounds`: vertices whose move would do so are
    held in the next correction, where other vertices compensate. Instead of bounds a function may be given:
    it returns a surface's vertices moved to places (n, 3) as far as it allows, and the mask (n,) of the
    vertices that it held. Raise CraftmeshError if a target is not positive or its grain does not exist.
    """
    facets = np.array(surface.facets)  # kernels take no read-only ones
    grains, target = checked_targets(targets, surface)
    rows, lists = _rows(surface.sides, grains), corner_lists(facets, len(surface.points))
    free = Classification(surface).free
    move = bounds if callable(bounds) else partial(guarded_move, bounds=bounds or MoveBounds())
    now, done = surface, 0
    first = drift = enclosed(now.points, facets, rows + 1, len(target) + 1)[1:] / target - 1
    held = np.zeros(len(free), bool)
    while done < rounds and np.abs(drift).max(initial=0) > TOLERANCE:
        progress(done / rounds, "restoring volumes")
        way = now.points - surface.points
        way += _displacement(
            np.array(now.points), facets, lists, rows, -drift * target, free & ~held[:, None]
        )
        places = surface.points + shortened(way, reach)
        points, held = move(now, places)
        now = replace(surface, points=points)
        drift = enclosed(points, facets, rows + 1, len(target) + 1)[1:] / target - 1
        done += 1
    report = {"rounds": done} | _drift_report("before", first) | _drift_report("after", drift)
    return now, report


def checked_targets(targets: Mapping[int, float], surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return the sorted ids (g,) and volumes (g,) of `targets`.

    Raise CraftmeshError for a volume that is not > 0 or is over LARGEST, or an id (-k for void k) that the
    surface lacks.
    """
    grains = as_array("grains with target volumes", list(targets), np.int64, (None,))
    target = as_array("target volumes", list(targets.values()), float, (None,), finite=False)
    sound = (target > 0) & (target <= LARGEST) & np.isin(grains, surface.sides)
    for grain, volume in zip(grains[~sound].tolist(), target[~sound].tolist()):
        raise CraftmeshError(
            f"target volume of grain {grain} is {volume}; expected a volume > 0, for a grain "
            "that the surface bounds"
        )
    order = np.argsort(grains)
    return grains[order], target[order]


def _drift_report(when: str, drift: np.ndarray) -> dict:
    """Return the mean and largest size of relative drifts (g,), under names that end in `when`."""
    size = np.abs(drift) if len(drift) else np.zeros(1)
    return {f"mean_drift_{when}": float(size.mean()), f"worst_drift_{when}": float(size.max())}


def _rows(sides: np.ndarray, grains: np.ndarray) -> np.ndarray:
    """Return the indices (m, 2) int32 in `grains` of the grains behind and ahead of each facet.

    -1 stands for a side that is not among `grains`, and for both sides of a facet within one grain.
    """
    bounds = np.isin(sides, grains) & (sides[:, :1] != sides[:, 1:])
    return np.where(bounds, np.searchsorted(grains, sides), -1).astype(np.int32)


def _displacement(
    points: np.ndarray,
    facets: np.ndarray,
    lists: tuple[np.ndarray, np.ndarray],
    grains: np.ndarray,
    missing: np.ndarray,
    mobile: np.ndarray,
) -> np.ndarray:
    """Return least-squares displacements (n, 3) that add the missing volumes, limited at each vertex.

    lists: the facets' corner lists; grains (m, 2): rows from `_rows`; missing (g,): volume that each grain
    lacks; mobile (n, 3): mask of coordinates that may change. The gradient of a volume at a vertex is a
    third of the area vectors of its facets. The weights are inverse vertex areas, so a patch moves by the
    same distance along its normal whatever the sizes of its facets.
    """
    area, reach = around_points(points, facets, lists)
    weight = 1 / np.maximum(area, 1e-9 * area.mean())
    start, rows, vectors = volume_gradients(points, facets, lists, grains)
    ways = weight[:, None] * mobile

    def gradient(k: int) -> "scipy.sparse.csr_array":
        return scipy.sparse.csr_array((vectors[:, k], rows, start), (len(points), len(missing)))

    system = sum(
        gradient(k).T @ (scipy.sparse.diags_array(ways[:, k]) @ gradient(k)) for k in range(3)
    ).tocsc()
    diagonal = system.diagonal()
    lift = np.where(diagonal > 0, DAMPING * diagonal, 1.0)
    pressure = np.atleast_1d(
        scipy.sparse.linalg.spsolve((system + scipy.sparse.diags_array(lift)).tocsc(), missing)
    )
    displacement = ways * np.stack([gradient(k) @ pressure for k in range(3)], axis=1)
    return shortened(displacement, STEP * reach)
