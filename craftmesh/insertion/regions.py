"""The grain of each region of a crack patch: the label of the places in it."""

import numpy as np

from craftmesh.surface.connectivity import edge_sides, joined, unique_edges
from craftmesh.surface.labels import labels_at
from craftmesh.surface.measure import area_vectors


def labels_of_patch(
    points: np.ndarray, triangles: np.ndarray, fixed: np.ndarray, facets: np.ndarray, sides: np.ndarray
) -> np.ndarray:
    """Return the label (t,) of each patch triangle (t, 3), by facets and sides (m, 2).

    A region hangs together across edges that are not fixed (t, 3), and has the label that the centres of
    most of its area have.
    """
    _, of_corner, count = unique_edges(triangles)
    a, b = edge_sides(of_corner, count > 1)
    free = ~fixed.ravel()[a]
    region = joined(len(triangles), a[free] // 3, b[free] // 3)
    found = labels_at(points[triangles].mean(axis=1), points, facets, sides)
    names, index = np.unique(found, return_inverse=True)
    area = np.zeros((int(region.max()) + 1, len(names)))
    np.add.at(area, (region, index), np.linalg.norm(area_vectors(points, triangles), axis=1))
    labels: np.ndarray = names[area.argmax(axis=1)][region]
    return labels
