"""Checks of a crack's invariants; each violation gives one sentence."""

import numpy as np

from craftmesh.cracks.height_parts import SHARPEST, best_fit_frame, height_parts
from craftmesh.cracks.sheets import sheets
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.measure import area_vectors, unit_normals
from craftmesh.types import Crack


def check_crack(crack: Crack) -> list[str]:
    """Return a sentence per violation: no triangles, zero area, reversed triangles, misplaced fronts."""
    if not len(crack.triangles):
        return ["the crack has no triangles"]
    breaches = _facet_breaches(crack)
    edges, _, count = unique_edges(crack.triangles)
    boundary = {frozenset(edge) for edge in edges[count == 1].tolist()}
    for number, front in enumerate(crack.fronts, 1):
        off = sum(frozenset(edge) not in boundary for edge in _edges(front))
        if off:
            breaches.append(f"front {number} has {off} edges that are not on the crack's boundary")
    return breaches


def _facet_breaches(crack: Crack) -> list[str]:
    """Return a sentence on triangles without area and one on reversed triangles.

    A triangle is reversed if its normal opposes the best-fit normal of its part. If a surface cannot be
    split into single-valued parts, a triangle is reversed if it is turned by over SHARPEST degrees from all
    its neighbours. Not checked: surfaces with more than two triangles at an edge.
    """
    vectors = area_vectors(crack.points, crack.triangles)
    flat = np.linalg.norm(vectors, axis=1) == 0
    breaches = [f"{int(flat.sum())} triangles have no area"] if flat.any() else []
    if flat.all():
        return breaches
    turned = 0
    for sheet in sheets(crack):
        if (unique_edges(sheet.triangles)[2] > 2).any():  # a branching surface has no plane of its own
            continue
        parts, fault = height_parts(sheet.points, sheet.triangles)
        if fault:
            turned += _turned_back(sheet.points, sheet.triangles)
        for part in [] if fault else parts:
            turned += int((area_vectors(*part) @ best_fit_frame(*part)[2] < 0).sum())
    if turned:
        breaches.append(f"{turned} triangles are reversed relative to their part or neighbours")
    return breaches


def _turned_back(points: np.ndarray, triangles: np.ndarray) -> int:
    """Return the number of triangles turned by more than SHARPEST degrees from all their neighbours."""
    _, of_corner, count = unique_edges(triangles)
    f, g = (side // 3 for side in edge_sides(of_corner, count == 2))
    normal = unit_normals(points, triangles)
    back = (normal[f] * normal[g]).sum(axis=1) < np.cos(np.radians(SHARPEST))
    every, sharp = (
        np.bincount(np.concatenate([f[x], g[x]]), minlength=len(triangles)) for x in (..., back)
    )
    return int(((every > 0) & (sharp == every)).sum())


def _edges(polyline: np.ndarray) -> list[tuple[int, int]]:
    return list(zip(polyline[:-1].tolist(), polyline[1:].tolist()))
