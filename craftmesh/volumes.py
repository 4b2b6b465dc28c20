"""Restoring the volumes of grains: the least-squares displacement that a smoothed surface is short of."""

from collections.abc import Callable, Mapping

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import spsolve

from craftmesh.connectivity import facet_edges
from craftmesh.errors import CraftmeshError
from craftmesh.kernels.smoothing import spoiled_facets
from craftmesh.kernels.triangles import intersecting_pairs
from craftmesh.measure import area_vectors, side_volumes
from craftmesh.progress import silent
from craftmesh.types import CRACK, Surface
from craftmesh.vertex_classes import vertex_classes, vertices_around

# A vertex moves at most this part of its mean edge in one round.
STEP = 0.3
# Facets whose normal would turn by more than about 60 degrees in one round are held.
TURN = 0.5
# Weight of the regularisation against the diagonal: the grains of a full box sum up to a fixed volume.
DAMPING = 1e-9


def restore_volumes(
    surface: Surface,
    targets: Mapping[int, float],
    tolerance: float = 5e-4,
    rounds: int = 8,
    min_quality: float = 0.2,
    min_edge: float = 0.0,
    progress: Callable[[float, str], None] = silent,
) -> tuple[Surface, dict]:
    """Return the surface with its vertices moved so that each grain has its target volume, and a report.

    targets: grain id -> volume in model units. The displacement is the smallest one, in the sense of the
    area-weighted mean square, that corrects all volumes together to first order; it is repeated up to
    `rounds` times, until every grain is within `tolerance` of its target. Vertices stay on their planes,
    edges and corners of the box, and those of crack facets stay where they are. No facet comes to
    intersect another one, turns over or falls below `min_quality` or `min_edge`; where one would, its
    vertices are held for the round and the others make up for it.
    Raises CraftmeshError when a target is not positive or the surface has no such grain.
    """
    volumes = side_volumes(surface.points, surface.facets, surface.sides)
    for grain, target in targets.items():
        if grain not in volumes or not target > 0:
            raise CraftmeshError(
                f"target volume {target} of grain {grain}: expected a volume > 0 of a grain of the surface"
            )
    grains = np.array(sorted(targets), np.int64)
    target = np.array([targets[int(g)] for g in grains])
    facets = surface.facets.astype(np.int64)
    free = _free_directions(surface, facets)
    first = drift = _drift(surface.points, surface, grains, target)
    points, done = surface.points.copy(), 0
    while done < rounds and len(drift) and np.abs(drift).max() > tolerance:
        progress(done / rounds, "restoring volumes")
        missing = -drift * target
        moved = _guarded_round(points, surface, facets, grains, missing, free, min_quality, min_edge)
        done += 1
        new_drift = _drift(moved, surface, grains, target)
        if np.abs(new_drift).sum() >= 0.99 * np.abs(drift).sum():
            break
        points, drift = moved, new_drift
    report = {"rounds": done} | _drift_report("before", first) | _drift_report("after", drift)
    return Surface(points, surface.facets, surface.sides, surface.kind), report


def _drift_report(when: str, drift: np.ndarray) -> dict:
    size = np.abs(drift) if len(drift) else np.zeros(1)
    return {f"mean_drift_{when}": float(size.mean()), f"worst_drift_{when}": float(size.max())}


def _drift(points: np.ndarray, surface: Surface, grains: np.ndarray, target: np.ndarray) -> np.ndarray:
    volumes = side_volumes(points, surface.facets, surface.sides)
    return np.array([volumes[int(g)] for g in grains]) / target - 1


def _free_directions(surface: Surface, facets: np.ndarray) -> np.ndarray:
    """(n, 3) bool: coordinates that may change."""
    free = ~vertex_classes(len(surface.points), facets, surface.sides, surface.kind).fixed
    free[facets[surface.kind == CRACK].ravel()] = False
    return free


def _guarded_round(points, surface, facets, grains, missing, free, min_quality, min_edge) -> np.ndarray:
    """Return points after one correction; vertices around facets that it would spoil are held."""
    gradient = _volume_gradient(points, facets, surface.sides, grains)
    reach, weight = _vertex_scales(points, facets)
    before = area_vectors(points, facets)
    free, rings = free.copy(), 0
    while free.any():
        moved = points + _displacement(gradient, missing, weight, free, STEP * reach)
        bad = spoiled_facets(moved, points, facets, min_quality, min_edge)
        bad |= _turned(before, area_vectors(moved, facets))
        bad[intersecting_pairs(moved, facets).ravel()] = True
        if not bad.any():
            return moved
        free[vertices_around(facets, bad, rings, len(points))] = False
        rings += 1
    return points


def _turned(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return np.einsum("ij,ij->i", before, after) < TURN * size


def _vertex_scales(points: np.ndarray, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (n,) mean edge lengths and (n,) inverse areas of the vertices.

    Weighted by inverse areas, a patch moves by one distance along its normal, whatever its facets' sizes.
    """
    edges = facet_edges(facets)
    length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    ends, n = edges.ravel(), len(points)
    count = np.maximum(np.bincount(ends, minlength=n), 1)
    area = np.repeat(np.linalg.norm(area_vectors(points, facets), axis=1) / 3, 3)
    area = np.bincount(facets.ravel(), area, n)
    return np.bincount(ends, np.repeat(length, 2), n) / count, 1 / np.maximum(area, 1e-9 * area.mean())


def _volume_gradient(points, facets, sides, grains) -> csr_matrix:
    """(g, 3n) change of each grain's volume with the coordinates: a third of the area vectors around."""
    third = area_vectors(points, facets) / 3
    columns = (3 * facets[:, :, None] + np.arange(3)).reshape(len(facets), 9)
    values = np.tile(third, 3)
    parts = []
    for side, sign in ((0, 1.0), (1, -1.0)):
        row = np.searchsorted(grains, sides[:, side])
        known = row < len(grains)
        known[known] = grains[row[known]] == sides[known, side]
        known &= sides[:, 0] != sides[:, 1]
        parts.append((np.repeat(row[known], 9), columns[known].ravel(), sign * values[known].ravel()))
    rows, columns, values = (np.concatenate(part) for part in zip(*parts))
    return csr_matrix((values, (rows, columns)), shape=(len(grains), 3 * len(points)))


def _displacement(gradient, missing, weight, free, limit) -> np.ndarray:
    """Return the (n, 3) least-squares displacement that adds the missing volumes, capped per vertex."""
    mobility = (weight[:, None] * free).ravel()
    weighted = gradient @ diags(mobility)
    system = (weighted @ gradient.T).tocsc()
    diagonal = system.diagonal()
    lift = np.where(diagonal > 0, DAMPING * diagonal, 1.0)
    pressure = spsolve((system + diags(lift)).tocsc(), missing)
    displacement = (weighted.T @ np.atleast_1d(pressure)).reshape(-1, 3)
    size = np.linalg.norm(displacement, axis=1)
    return displacement * np.minimum(1.0, limit / np.maximum(size, 1e-300))[:, None]
