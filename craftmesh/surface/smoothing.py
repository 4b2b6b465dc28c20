"""Smoothing of a surface: passes that draw each vertex to its neighbours, on a line only along the line."""

from collections.abc import Sequence

import numpy as np
import scipy

from craftmesh.surface.classification import Classification
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.laps import drawn_by, laps


def smoothing_neighbours(classes: Classification) -> "scipy.sparse.csr_array":
    """Return a mask (n, n), True where the vertex of the row is drawn to the vertex of the column.

    Vertices off all lines are drawn to all neighbours, vertices on lines and at junctions to neighbours
    along lines. On a box edge a vertex follows the edge. Where a grain boundary reaches the edge, it
    follows the boundary's lines instead, so that the boundary can slide along the edge.
    """
    facets, held = np.array(classes.surface.facets), classes.held
    lists = corner_lists(facets, len(held))
    start, ids = drawn_by(facets, classes.patch, held, lists)
    return scipy.sparse.csr_array((np.ones(len(ids), bool), ids, start), (len(held),) * 2)


def lapped(
    points: np.ndarray, weights: Sequence[float], drawn: "scipy.sparse.csr_array", stays: np.ndarray
) -> np.ndarray:
    """Return points (n, 3) after a smoothing pass per weight; coordinates in the mask `stays` (n, 3) stay.

    In each pass all points move towards the means of the neighbours that attract them, by the fraction
    `weight` of the distance. drawn: matrix from `smoothing_neighbours`.
    """
    return laps(np.array(points), np.array(weights, float), drawn.indptr, drawn.indices, stays)
