"""Invariants of a crack, one sentence per breach."""

import numpy as np

from craftmesh.cracks.frame import best_fit_frame
from craftmesh.cracks.height_parts import height_parts
from craftmesh.cracks.sheets import sheets
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.types import Crack


def check_crack(crack: Crack) -> list[str]:
    """Return one sentence per breach: empty, degenerate or folded triangles, bad boundary, bad fronts."""
    if not len(crack.triangles):
        return ["the crack has no triangles"]
    if not np.isfinite(crack.points).all():
        return ["the crack has points that are not finite"]
    breaches = _facet_breaches(crack)
    edges, _, count = unique_edges(crack.triangles)
    boundary = {frozenset(edge) for edge in edges[count == 1].tolist()}
    for number, front in enumerate(crack.fronts, 1):
        off = sum(frozenset(edge) not in boundary for edge in _edges(front))
        if off:
            breaches.append(f"front {number} has {off} edges that are not on the crack's boundary")
    return breaches


def _facet_breaches(crack: Crack) -> list[str]:
    """Return the breaches of single triangles: no area, or a normal against that of their part's plane."""
    vectors = area_vectors(crack.points, crack.triangles)
    flat = np.linalg.norm(vectors, axis=1) == 0
    breaches = [f"{int(flat.sum())} triangles have no area"] if flat.any() else []
    if flat.all():
        return breaches
    turned = 0
    for sheet in sheets(crack):
        if (unique_edges(sheet.triangles)[2] > 2).any():  # it branches: no plane is that of all of it
            continue
        for rows in height_parts(sheet.points, sheet.triangles)[0]:
            normal = best_fit_frame(sheet.points, sheet.triangles[rows])[2]
            turned += int((area_vectors(sheet.points, sheet.triangles[rows]) @ normal < 0).sum())
    if turned:
        breaches.append(f"{turned} triangles are turned over against their part's best-fit plane")
    return breaches


def _edges(polyline: np.ndarray) -> list[tuple[int, int]]:
    return list(zip(polyline[:-1].tolist(), polyline[1:].tolist()))
