"""Stresses of elements at the nodes of their grains."""

import numpy as np

from craftmesh.jit import kernel
from craftmesh.solve.kernels.elements import gradients, strain_at


@kernel
def add_stresses(
    points, tets, part, stiffness, slopes, weights, displacement, spread, place, stress, volume
):
    """Add each element's stresses times its volume to `stress` (p, 6) at its places (m, k), and the volume.

    spread (k, q): how the values at the q integration points go to the k nodes.
    """
    grads, inverse = np.empty((tets.shape[1], 3)), np.empty((3, 3))
    strain, at_points = np.empty(6), np.empty((len(weights), 6))
    for tet in range(len(tets)):
        size = 0.0
        for q in range(len(weights)):
            size += weights[q] * gradients(points, tets[tet], slopes[q], inverse, grads)
            strain_at(grads, tets[tet], displacement, strain)
            for row in range(6):
                at_points[q, row] = 0.0
                for column in range(6):
                    at_points[q, row] += stiffness[part[tet], row, column] * strain[column]
        for k in range(tets.shape[1]):
            at = place[tet, k]
            volume[at] += size
            for row in range(6):
                for q in range(len(weights)):
                    stress[at, row] += size * spread[k, q] * at_points[q, row]
