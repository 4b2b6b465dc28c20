"""Repair a surface where facets intersect or are degenerate, before it is split into grains."""

import numpy as np

from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.guarded_move import PATIENCE, vertices_around
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import is_degenerate, mean_edges, volumes_of, worst_drift
from craftmesh.surface.smoothing import lapped, smoothing_neighbours
from craftmesh.types import Surface

# Most smoothing passes. Points of faulty facets move; after each PATIENCE + 1 passes, points of one more
# ring of facets around these move too.
SMOOTHING_PASSES = 24
WEIGHT = 0.7  # fraction of the distance to the mean of its neighbours that a point moves in a pass
# Most facets that a report names.
MAX_NAMED = 1000


def repair_surface(surface: Surface) -> tuple[Surface, dict]:
    """Return the surface with points moved so that fewer facets intersect or are degenerate, and a report.

    Points near such facets move towards the mean of their neighbours: on triple lines along these, within
    box planes and edges; points of the crack and corners of the box stay. The best of at most
    SMOOTHING_PASSES passes counts, so faults may be left. All grains share the points, so neighbours stay
    conformal. The result depends on the surface alone, so jobs that mesh different grains get the same
    bits. A surface without faults is returned unchanged.
    """
    facets = surface.facets.astype(np.int64)
    faulty = faulty_facets(surface.points, facets)
    first, best = faulty, (surface.points, faulty)
    if faulty.any():
        classes = Classification(surface)
        mobile, drawn = classes.free, smoothing_neighbours(classes)
        points = surface.points
        for done in range(SMOOTHING_PASSES):
            around = vertices_around(facets, faulty, done // (PATIENCE + 1), len(points))
            points = lapped(points, [WEIGHT], drawn, ~(mobile & around[:, None]))
            faulty = faulty_facets(points, facets)
            if faulty.sum() < best[1].sum():
                best = points, faulty
            if not faulty.any():
                break
    repaired = Surface(best[0], surface.facets, surface.sides, surface.kind)
    return (repaired if first.any() else surface), _report(surface, repaired, first, best[1])


def faulty_facets(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of facets (m, 3) that intersect or touch others, or have almost no area.

    The search for pairs ends at a large number (`intersecting_pairs`), so then the mask may be incomplete.
    """
    faulty = is_degenerate(points, facets)
    faulty[intersecting_pairs(points, facets).ravel()] = True
    return faulty


def _report(before: Surface, after: Surface, first: np.ndarray, left: np.ndarray) -> dict:
    """Return the number of faulty facets `first` (m,); if any, their ids and grains, moves, faults left."""
    report = {"faults": int(first.sum())}
    if not first.any():
        return report
    grains = np.unique(before.sides[first])
    moves = np.linalg.norm(after.points - before.points, axis=1)
    moved = np.flatnonzero(moves)
    edges = mean_edges(after.points, unique_edges(after.facets)[0])
    volumes = [volumes_of(s) for s in (before, after)]
    return report | {
        "facets": np.flatnonzero(first)[:MAX_NAMED].tolist(),
        "grains": grains[grains > 0].tolist(),
        "points_moved": len(moved),
        "largest_move": float(moves.max()),
        "largest_move_edges": float((moves[moved] / edges[moved]).max(initial=0.0)),
        "volume_drift_worst": worst_drift(*volumes),
        "faults_left": int(left.sum()),
    }
