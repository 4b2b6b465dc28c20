"""Jacobians of 10-node tetrahedra where the solvers integrate."""

import numpy as np

from craftmesh.jit import kernel

# The four integration points of C3D10 in Abaqus and CalculiX lie at these barycentric coordinates, the
# larger one at each corner in turn (Hammer & Stroud 1956, degree 2).
NEAR, FAR = (5 + 3 * np.sqrt(5)) / 20, (5 - np.sqrt(5)) / 20


@kernel
def smallest_jacobians(points, tets):
    """Return the least Jacobian determinant (m,) over the four integration points of each element.

    points (n, 3) float64; tets (m, 10) int64 in Abaqus' order. An element with straight edges and mid
    nodes in their middles has six times its volume at every point.
    """
    least = np.full(len(tets), np.inf)
    slopes = np.zeros((10, 3))
    for near in range(4):
        _shape_slopes(near, slopes)
        for tet in range(len(tets)):
            least[tet] = min(least[tet], _determinant(points, tets[tet], slopes))
    return least


@kernel
def _shape_slopes(near, slopes):
    """Fill `slopes` (10, 3): derivatives of the shape functions by the coordinates of corners 2, 3, 4."""
    weight = np.full(4, FAR)
    weight[near] = NEAR
    for axis in range(3):
        slopes[:, axis] = 0.0
        slopes[0, axis] = 1.0 - 4.0 * weight[0]
        slopes[axis + 1, axis] = 4.0 * weight[axis + 1] - 1.0
        place = 4
        for a, b in ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)):
            # 4 L_a L_b, where L_1 falls as any other coordinate grows
            slope_a = -1.0 if a == 0 else (1.0 if a == axis + 1 else 0.0)
            slope_b = -1.0 if b == 0 else (1.0 if b == axis + 1 else 0.0)
            slopes[place, axis] = 4.0 * (slope_a * weight[b] + slope_b * weight[a])
            place += 1


@kernel
def _determinant(points, nodes, slopes):
    j = np.zeros((3, 3))
    first = points[nodes[0]]
    for k in range(1, 10):  # slopes add up to zero, so the first node may be the origin
        for i in range(3):
            offset = points[nodes[k], i] - first[i]
            for axis in range(3):
                j[i, axis] += offset * slopes[k, axis]
    return (
        j[0, 0] * (j[1, 1] * j[2, 2] - j[1, 2] * j[2, 1])
        - j[0, 1] * (j[1, 0] * j[2, 2] - j[1, 2] * j[2, 0])
        + j[0, 2] * (j[1, 0] * j[2, 1] - j[1, 1] * j[2, 0])
    )
