"""Smoothing of a surface: the neighbours that each vertex is drawn to, along lines on a line."""

import numpy as np
from scipy.sparse import csr_array

from craftmesh.surface.classification import Classification
from craftmesh.surface.kernels.facet_measures import ways_to_means


def smoothing_neighbours(classes: Classification) -> csr_array:
    """Return (n, n) 1.0 where the vertex of the row is drawn to that of the column.

    Vertices off all lines have all their neighbours; vertices on lines and at junctions those along
    lines. On an edge of the box a vertex follows the edge, but where a grain boundary reaches the edge
    it follows the boundary's lines, so that the boundary may slide along.
    """
    tail, head = np.concatenate([classes.features.edges, classes.features.edges[:, ::-1]]).T
    is_line = np.tile(classes.features.is_feature, 2)
    on_box_edge = classes.held.sum(axis=1) >= 2
    along_box_edge = is_line & ((classes.held[tail] & classes.held[head]).sum(axis=1) >= 2)
    meets_boundary = on_box_edge & (classes.degree > 2)
    drawn = is_line | (classes.degree[tail] == 0)
    drawn &= ~(along_box_edge & meets_boundary[tail])
    tail, head = tail[drawn], head[drawn]
    return csr_array((np.ones(len(tail)), (tail, head)), (len(on_box_edge),) * 2)


def to_neighbours(points: np.ndarray, drawn: csr_array) -> np.ndarray:
    """Return the ways (n, 3) from points to the means of those that they are drawn to, 0 without any.

    drawn: by `smoothing_neighbours`.
    """
    return ways_to_means(points, drawn.indptr, drawn.indices)
