"""The stress of 10-node elements at given places."""

import numpy as np

from craftmesh.fracture.kernels.fields import contract
from craftmesh.jit import kernel

NEWTON_STEPS = 12
# An element holds a place when no barycentric coordinate is further below 0.
OUTSIDE = 1e-6
ENDS = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])


@kernel
def fill_stresses(
    points, displacement, tets, grain, stiffness, eigenstrain, places, candidates, stress, missed
):
    """Fill the stress (k, 3, 3) at places (k, 3) and how far each lies outside its element (k,).

    points, displacement (n, 3); tets (e, 10); grain (e,) rows of stiffness (g, 6, 6)
    and eigenstrain (g, 3, 3); candidates (k, c):
    elements in the order in which they are tried; the first that holds the place, or the nearest, counts.
    """
    share, value, slope = np.zeros(4), np.zeros(10), np.zeros((10, 3))
    best = np.zeros(4)
    for k in range(len(places)):
        chosen = -1
        missed[k] = np.inf
        for element in candidates[k]:
            _locate(points, tets[element], places[k], share, value, slope)
            outside = max(0.0, -np.min(share))
            if outside < missed[k]:
                missed[k] = outside
                chosen = element
                best[:] = share
            if outside <= OUTSIDE:
                break
        if chosen >= 0:
            _fill_shapes(best, value, slope)
            own = grain[chosen]
            gradient = -eigenstrain[own]
            _add_gradient(points, displacement, tets[chosen], slope, gradient)
            contract(stiffness[own], gradient, stress[k])


@kernel
def _fill_shapes(share, value, slope):
    """Fill shape functions and their slopes by the coordinates of corners 2, 3, 4."""
    for k in range(4):
        value[k] = share[k] * (2.0 * share[k] - 1.0)
        for axis in range(3):
            slope[k, axis] = (4.0 * share[k] - 1.0) * _share_slope(k, axis)
    for k in range(6):
        a, b = ENDS[k]
        value[4 + k] = 4.0 * share[a] * share[b]
        for axis in range(3):
            slope[4 + k, axis] = 4.0 * (share[a] * _share_slope(b, axis) + share[b] * _share_slope(a, axis))


@kernel
def _share_slope(k, axis):
    return -1.0 if k == 0 else (1.0 if k == axis + 1 else 0.0)


@kernel
def _jacobian(points, nodes, slope):
    j = np.zeros((3, 3))
    for k in range(10):
        for i in range(3):
            for axis in range(3):
                j[i, axis] += points[nodes[k], i] * slope[k, axis]
    return j


@kernel
def _locate(points, nodes, place, share, value, slope):
    """Fill the barycentric coordinates of a place in an element, by Newton's method."""
    share[:] = 0.25
    for _ in range(NEWTON_STEPS):
        _fill_shapes(share, value, slope)
        off = place.copy()
        for k in range(10):
            for i in range(3):
                off[i] -= value[k] * points[nodes[k], i]
        j = _jacobian(points, nodes, slope)
        if abs(np.linalg.det(j)) < 1e-300:
            break
        step = np.linalg.solve(j, off)
        largest = np.max(np.abs(step))
        scale = min(1.0, 0.5 / largest) if largest > 0.0 else 1.0
        for axis in range(3):
            share[axis + 1] += scale * step[axis]
        share[0] = 1.0 - share[1] - share[2] - share[3]
        if largest < 1e-10:
            break


@kernel
def _add_gradient(points, displacement, nodes, slope, gradient):
    inverse = np.linalg.inv(_jacobian(points, nodes, slope))
    for k in range(10):
        for j in range(3):
            along = 0.0
            for axis in range(3):
                along += slope[k, axis] * inverse[axis, j]
            for i in range(3):
                gradient[i, j] += displacement[nodes[k], i] * along
