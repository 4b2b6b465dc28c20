"""Repair of a surface where facets intersect or are degenerate, before it is cut into grains."""

import numpy as np

from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import is_degenerate, mean_edges, side_volumes, volume_drift
from craftmesh.surface.patches import facets_beyond_box, vertices_around
from craftmesh.surface.smoothing import smoothing_neighbours, to_neighbours
from craftmesh.types import Surface

ROUNDS = 24
# Rounds after which the neighbourhood that moves grows by a ring of facets.
PATIENCE = 4
WEIGHT = 0.7
HOLDS = 6
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
            around = vertices_around(facets, faulty, done // PATIENCE, len(points))
            displacement = WEIGHT * to_neighbours(points, drawn) * (mobile & around[:, None])
            points, faulty = _guarded(points, displacement, facets, surface.kind, faulty)
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


def _guarded(
    points: np.ndarray, displacement: np.ndarray, facets: np.ndarray, kind: np.ndarray, faulty: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return points after the displacement, less where it would spoil sound facets, and what is faulty.

    Where every try leaves more facets faulty than before, the one with the fewest is taken: the way back
    may lead through them.
    """
    held = np.zeros(len(points), bool)
    outside = facets_beyond_box(points, points, facets, kind)
    fewest = None
    for _ in range(HOLDS):
        moved = np.where(held[:, None], points, points + displacement)
        if np.array_equal(moved, points):
            break
        now = faulty_facets(moved, facets)
        beyond = facets_beyond_box(moved, points, facets, kind) & ~outside
        if not beyond.any():
            if now.sum() <= faulty.sum():
                return moved, now
            if fewest is None or now.sum() < fewest[1].sum():
                fewest = moved, now
        held |= vertices_around(facets, (now & ~faulty) | beyond, 0, len(points))
    return fewest or (points, faulty)


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
