"""Smoothing of a surface: the neighbours that each vertex is drawn to; on a line, those along it."""

import numpy as np
from scipy.sparse import csr_array

from craftmesh.surface.classification import Classification
from craftmesh.surface.kernels.facet_measures import ways_to_means


def smoothing_neighbours(classes: Classification) -> csr_array:
    """Return a sparse matrix (n, n), 1.0 where the vertex of the row is drawn to the vertex of the column.

    Vertices off all lines are drawn to all neighbours, vertices on lines and at junctions to neighbours
    along lines. On a box edge a vertex follows the edge. Where a grain boundary reaches the edge, it
    follows the boundary's lines instead, so that the boundary can slide along the edge.
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
    """Return vectors (n, 3) from points to the means of the neighbours that they are drawn to, else 0.

    drawn: matrix from `smoothing_neighbours`.
    """
    return ways_to_means(points, drawn.indptr, drawn.indices)
