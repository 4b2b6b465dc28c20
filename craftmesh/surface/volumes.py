"""Restoring the volumes of grains: the least-squares displacement that a smoothed surface is short of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import spsolve

from craftmesh.arguments import LARGEST, as_array
from craftmesh.errors import CraftmeshError
from craftmesh.progress import silent
from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import facet_edges
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, mean_edges, spoiled_facets, swept_volumes
from craftmesh.surface.patches import facets_beyond_box, vertices_around
from craftmesh.surface.wedges import wedge_guard
from craftmesh.types import Surface

# A vertex moves at most this part of its mean edge in one round.
STEP = 0.3
# Facets whose normal would turn by more than about 60 degrees in one round are held.
TURN = 0.5
# Rounds of holding single vertices before whole neighbourhoods are held.
PATIENCE = 3
# Weight of the regularisation against the diagonal: the grains of a full box sum up to a fixed volume.
DAMPING = 1e-9


@dataclass(frozen=True)
class RestoringLimits:
    """What ends the restoring of volumes, and what a move may do to facets and vertices.

    tolerance: part of its target by which a grain's volume may be off; rounds: corrections at most.
    min_quality (4 sqrt(3) area / sum of squared edges) and min_edge (model units): no facet falls below
    them by a move. keep_wedges: no wedge gets sharper than SHARP_WEDGE and than it was. reach (n,) in model
    units: how far a vertex may come from its first place; None: no limit.
    """

    tolerance: float = 5e-4
    rounds: int = 8
    min_quality: float = 0.2
    min_edge: float = 0.0
    keep_wedges: bool = False
    reach: np.ndarray | None = None


def restore_volumes(
    surface: Surface,
    targets: Mapping[int, float],
    limits: RestoringLimits | None = None,
    progress: Callable[[float, str], None] = silent,
) -> tuple[Surface, dict]:
    """Return the surface with its vertices moved so that each grain has its target volume, and a report.

    targets: grain id, or -k for void k, -> volume in model units. The displacement is the smallest one,
    in the sense of the area-weighted mean square, that corrects all volumes together to first order; it
    is repeated within the `limits`. Vertices stay on their planes, edges and corners of the box; those
    of crack facets do not move. No facet comes to intersect another one, turns over or breaks the
    limits; where one would, its vertices are held, and in the next round the others make up for it.
    Raises CraftmeshError when a target is not positive or the surface has no such grain.
    """
    limits = limits or RestoringLimits()
    facets = surface.facets.astype(np.int64)
    grains, target = checked_targets(targets, surface)
    signs = _signs(surface.sides, grains)
    free = Classification(surface).free
    points, done = surface.points.copy(), 0
    first = drift = signs @ swept_volumes(points, facets) / target - 1
    held = np.zeros(len(points), bool)
    while done < limits.rounds and np.abs(drift).max(initial=0) > limits.tolerance:
        progress(done / limits.rounds, "restoring volumes")
        displacement = _displacement(points, facets, signs, -drift * target, free & ~held[:, None])
        if limits.reach is not None:
            way = points + displacement - surface.points
            far = np.maximum(np.linalg.norm(way, axis=1), 1e-300)
            displacement = surface.points + way * np.minimum(1.0, limits.reach / far)[:, None] - points
        points, held = _guarded_step(points, displacement, facets, surface.kind, limits)
        drift = signs @ swept_volumes(points, facets) / target - 1
        done += 1
    report = {"rounds": done} | _drift_report("before", first) | _drift_report("after", drift)
    return Surface(points, surface.facets, surface.sides, surface.kind), report


def checked_targets(targets: Mapping[int, float], surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return the grains (g,), sorted, and their target volumes (g,), all > 0; raises CraftmeshError."""
    grains = as_array("grains with target volumes", list(targets), np.int64, (None,))
    target = as_array("target volumes", list(targets.values()), float, (None,), finite=False)
    sound = (target > 0) & (target <= LARGEST) & np.isin(grains, surface.sides)
    for grain, volume in zip(grains[~sound].tolist(), target[~sound].tolist()):
        raise CraftmeshError(
            f"target volume of grain {grain} is {volume}; expected a volume > 0 of a grain "
            "that the surface bounds"
        )
    order = np.argsort(grains)
    return grains[order], target[order]


def _drift_report(when: str, drift: np.ndarray) -> dict:
    size = np.abs(drift) if len(drift) else np.zeros(1)
    return {f"mean_drift_{when}": float(size.mean()), f"worst_drift_{when}": float(size.max())}


def _signs(sides: np.ndarray, grains: np.ndarray) -> csr_array:
    """Return (g, m): 1 where a facet is the boundary of a grain behind it, -1 of one ahead of it."""
    bounds = np.isin(sides, grains) & (sides[:, :1] != sides[:, 1:])
    facet, side = np.nonzero(bounds)
    row = np.searchsorted(grains, sides[facet, side])
    return csr_array((1.0 - 2 * side, (row, facet)), (len(grains), len(sides)))


def _guarded_step(
    points: np.ndarray,
    displacement: np.ndarray,
    facets: np.ndarray,
    kind: np.ndarray,
    limits: RestoringLimits,
) -> tuple[np.ndarray, np.ndarray]:
    """Return points after a displacement, and (n,) bool the vertices held so that it spoils no facet."""
    before = area_vectors(points, facets)
    sharpened = wedge_guard(points, facets) if limits.keep_wedges else None
    held, attempt = np.zeros(len(points), bool), 0
    changed = np.ones(len(facets), bool)  # what has moved since facets were looked at for intersections
    while True:
        moved = np.where(held[:, None], points, points + displacement)
        bad = spoiled_facets(moved, points, facets, limits.min_quality, limits.min_edge)
        bad |= facets_beyond_box(moved, points, facets, kind)
        bad |= _turned(before, area_vectors(moved, facets))
        if sharpened is not None:
            bad |= sharpened(moved)
        bad[intersecting_pairs(moved, facets, chosen=changed).ravel()] = True
        if not bad.any() or held.all():
            return moved, held
        newly = vertices_around(facets, bad, max(0, attempt - PATIENCE), len(points)) & ~held
        held |= newly
        changed = newly[facets].any(axis=1)
        attempt += 1


def _turned(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return np.einsum("ij,ij->i", before, after) < TURN * size


def _displacement(
    points: np.ndarray, facets: np.ndarray, signs: csr_array, missing: np.ndarray, mobile: np.ndarray
) -> np.ndarray:
    """Return the (n, 3) least-squares displacement that adds the missing volumes, capped per vertex.

    missing (g,): what each grain lacks; mobile (n, 3) bool: coordinates that may change. A volume changes
    with a vertex by a third of the area vectors of its facets there. Weighted by the inverse areas of
    vertices, a patch moves by one distance along its normal, whatever its facets' sizes.
    """
    area = np.repeat(np.linalg.norm(area_vectors(points, facets), axis=1) / 3, 3)
    area = np.bincount(facets.ravel(), area, len(points))
    reach, weight = mean_edges(points, facet_edges(facets)), 1 / np.maximum(area, 1e-9 * area.mean())
    first = np.arange(0, facets.size + 1, 3)
    corners = csr_array((np.ones(facets.size), facets.ravel(), first), (len(facets), len(points)))
    third = area_vectors(points, facets) / 3
    gradient = [signs @ diags_array(third[:, k]) @ corners for k in range(3)]
    weighted = [matrix @ diags_array(weight * mobile[:, k]) for k, matrix in enumerate(gradient)]
    system = sum(left @ matrix.T for left, matrix in zip(weighted, gradient)).tocsc()
    diagonal = system.diagonal()
    lift = np.where(diagonal > 0, DAMPING * diagonal, 1.0)
    pressure = np.atleast_1d(spsolve((system + diags_array(lift)).tocsc(), missing))
    displacement = np.stack([matrix.T @ pressure for matrix in weighted], axis=1)
    size = np.linalg.norm(displacement, axis=1)
    return displacement * np.minimum(1.0, STEP * reach / np.maximum(size, 1e-300))[:, None]
