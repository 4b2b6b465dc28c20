"""Repair of a surface where facets intersect or are degenerate, before it is cut into grains."""

import numpy as np

from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.guarded_move import PATIENCE, vertices_around
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import is_degenerate, mean_edges, side_volumes, volume_drift
from craftmesh.surface.smoothing import smoothing_neighbours, to_neighbours
from craftmesh.types import Surface

# The neighbourhood that moves grows by a ring of facets after each PATIENCE + 1 of these.
ROUNDS = 24
WEIGHT = 0.7
# Facets that a report names at most.
MAX_NAMED = 1000


def repair_surface(surface: Surface) -> tuple[Surface, dict]:
    """Return the surface with points moved so that fewer facets intersect or are degenerate, and a report.

    Points near such facets go towards the mean of their neighbours: along triple lines, within the
    planes, edges and corners of the box; those of the crack stay. All grains share the points, so both
    neighbours see the same change. A function of the surface alone: who meshes a part of the grains
    repairs all of it and gets the same bits. Without faults the surface comes back as it is.
    """
    facets = surface.facets.astype(np.int64)
    faulty = faulty_facets(surface.points, facets)
    first, best = faulty, (surface.points, faulty)
    if faulty.any():
        classes = Classification(surface)
        mobile, drawn = classes.free, smoothing_neighbours(classes)
        points = surface.points
        for done in range(ROUNDS):
            around = vertices_around(facets, faulty, done // (PATIENCE + 1), len(points))
            displacement = WEIGHT * to_neighbours(points, drawn) * (mobile & around[:, None])
            points = points + displacement
            faulty = faulty_facets(points, facets)
            if faulty.sum() < best[1].sum():
                best = points, faulty
            if not faulty.any():
                break
    repaired = Surface(best[0], surface.facets, surface.sides, surface.kind)
    return (repaired if first.any() else surface), _report(surface, repaired, first, best[1])


def faulty_facets(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return (m,) bool: facets that intersect others or have no area to speak of."""
    faulty = is_degenerate(points, facets)
    faulty[intersecting_pairs(points, facets).ravel()] = True
    return faulty


def _report(before: Surface, after: Surface, first: np.ndarray, left: np.ndarray) -> dict:
    report = {"faults": int(first.sum())}
    if not first.any():
        return report
    grains = np.unique(before.sides[first])
    moves = np.linalg.norm(after.points - before.points, axis=1)
    moved = np.flatnonzero(moves)
    edges = mean_edges(after.points, unique_edges(after.facets)[0])
    volumes = [side_volumes(s.points, s.facets, s.sides) for s in (before, after)]
    drift = volume_drift(*volumes)
    return report | {
        "facets": np.flatnonzero(first)[:MAX_NAMED].tolist(),
        "grains": grains[grains > 0].tolist(),
        "points_moved": len(moved),
        "largest_move": float(moves.max()),
        "largest_move_edges": float((moves[moved] / edges[moved]).max(initial=0.0)),
        "volume_drift_worst": max(map(abs, drift.values()), default=0.0),
        "faults_left": int(left.sum()),
    }
