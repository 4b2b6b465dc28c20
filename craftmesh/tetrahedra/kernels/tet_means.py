"""Means at the points of tetrahedra: of aspect ratios and of edge lengths."""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import squared_distance
from craftmesh.tetrahedra.kernels.tet_quality import INVERTED, all_aspect_ratios


@lean_kernel
def mean_ratios(points, tets, ratio, mean, count):
    """Write aspect ratios (t,) of tets and the mean (n,) of the tets at each point; return the mean of all.

    The ratio is 0 for a dead tet and INVERTED for a flat tet; the mean of all excludes both. count (n,):
    work array for the numbers of tets.
    """
    mean[:], count[:] = 0.0, 0
    total, sound = 0.0, 0
    all_aspect_ratios(points, tets, len(ratio), ratio)
    for t in range(len(ratio)):
        if ratio[t] > 0.0:
            for k in range(4):
                mean[tets[t, k]] += ratio[t]
                count[tets[t, k]] += 1
            if ratio[t] < INVERTED:
                total, sound = total + ratio[t], sound + 1
    for v in range(len(mean)):
        mean[v] /= max(count[v], 1)
    return total / max(sound, 1)


@lean_kernel
def mean_edges(points, tets, mean, count):
    """Write the mean length (n,) of the edges at each point; an edge counts once for each of its tets.

    count (n,): work array for the numbers of edges.
    """
    mean[:], count[:] = 0.0, 0
    for t in range(len(tets)):
        for i in range(3):
            for j in range(i + 1, 4):
                a, b = tets[t, i], tets[t, j]
                length = np.sqrt(squared_distance(points, a, b))
                for v in (a, b):
                    mean[v] += length
                    count[v] += 1
    for v in range(len(mean)):
        mean[v] /= max(count[v], 1)
