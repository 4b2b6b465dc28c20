"""Smaller facets at places where those of a crack met others or left it: their edges are halved."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.insertion.cut import CutSurface, split_edges
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import unique_edges

SMALL = 0.15  # of the least length: no edge is halved into shorter ones


def split_near(surface: CutSurface, sheet: Sheet, places: np.ndarray, least: float) -> CutSurface:
    """Split the edges of facets near places (k, 3) that are not too short; no point moves.

    Smaller facets tell better on which side of a curved crack they are. least: the least target length.
    """
    corners = surface.points[surface.facets]
    centre = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    rows = np.flatnonzero(cKDTree(places).query(centre)[0] < reach + SMALL * least)
    edges, _, _ = unique_edges(surface.facets[rows])
    step = np.diff(surface.points[edges], axis=1)[:, 0]
    edges = edges[np.linalg.norm(step, axis=1) > 2 * SMALL * least]
    middle = surface.points[edges].mean(axis=1)
    size = surface.size[edges].mean(axis=1) / 2
    result = split_edges(surface, edges, middle, size)
    result.psi[len(surface.points) :] = sheet.offset(middle)
    return result
