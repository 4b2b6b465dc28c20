"""Edges of crack facets swapped for the other diagonal of their two facets."""

from dataclasses import replace

import numpy as np

from craftmesh.insertion.cut import CutSurface
from craftmesh.insertion.guarded_move import LEAST_ANGLE, meet_others
from craftmesh.surface.connectivity import facet_edges
from craftmesh.surface.measure import facet_angles
from craftmesh.types import CRACK

# Degrees: a facet with a larger angle is a cap. One of 177 beside the trace of a boundary, square to the
# facets around, was taken for a fold of the crack and left 2 flat tetrahedra.
CAP = 165.0


def swap_at(facets: np.ndarray, sides: np.ndarray, kind: np.ndarray, a: int, b: int) -> tuple | None:
    """Return the rows (2,) of the facets at edge (a, b) and their corners (2, 3) with the other diagonal.

    None where these are not two, of one kind between the same sides, and where that diagonal is an edge.
    """
    rows = np.flatnonzero((facets == a).any(axis=1) & (facets == b).any(axis=1))
    if len(rows) != 2 or (sides[rows[0]] != sides[rows[1]]).any() or kind[rows[0]] != kind[rows[1]]:
        return None
    c, d = (int(facets[row][~np.isin(facets[row], (a, b))][0]) for row in rows)
    if ((facets == c).any(axis=1) & (facets == d).any(axis=1)).any():
        return None
    after = np.stack([np.where(facets[rows[0]] == a, d, facets[rows[0]]), facets[rows[1]]])
    after[1][after[1] == b] = c
    return rows, after


def is_sound(points: np.ndarray, facets: np.ndarray, rows: np.ndarray, after: np.ndarray) -> bool:
    """Tell whether facets `rows` may become `after` (k, 3): no needles, none through another facet."""
    if (facet_angles(points, after).min(axis=1) < LEAST_ANGLE).any():
        return False
    return not meet_others(points, after, np.delete(facets, rows, axis=0))


def without_caps(surface: CutSurface) -> CutSurface:
    """Return the surface with the longest edges of crack facets over CAP degrees swapped, where sound."""
    crack = np.flatnonzero(surface.kind >= CRACK)
    angles = facet_angles(surface.points, surface.facets[crack])
    caps = np.flatnonzero(angles.max(axis=1) > CAP)
    if not len(caps):
        return surface
    # the edge opposite to corner k runs from corner k + 1 on
    corner = (angles[caps].argmax(axis=1) + 1) % 3
    edges = facet_edges(surface.facets[crack[caps]]).reshape(-1, 3, 2)[np.arange(len(caps)), corner]
    facets = surface.facets.copy()
    for a, b in edges.tolist():
        found = swap_at(facets, surface.sides, surface.kind, a, b)
        if found is not None and is_sound(surface.points, facets, *found):
            facets[found[0]] = found[1]
    return replace(surface, facets=facets)
