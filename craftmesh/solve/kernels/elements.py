"""Stiffness and nodal forces of isoparametric elements, by numerical integration.

slopes (q, k, 3): derivatives of the k shape functions at q points by the element's own coordinates; weights
(q,). Stiffnesses (6, 6) are in order 11, 22, 33, 12, 13, 23 with engineering shear strains.
"""

import numpy as np

from craftmesh.jit import kernel, lean_kernel


@lean_kernel
def gradients(points, nodes, slopes, inverse, out):
    """Fill `out` (k, 3) with the shape functions' gradients at a point; return its Jacobian determinant.

    slopes (k, 3): at the point; inverse (3, 3): scratch.
    """
    j = inverse
    j[:, :] = 0.0
    for k in range(len(nodes)):
        for i in range(3):
            for axis in range(3):
                j[i, axis] += points[nodes[k], i] * slopes[k, axis]
    a00 = j[1, 1] * j[2, 2] - j[1, 2] * j[2, 1]
    a01 = j[0, 2] * j[2, 1] - j[0, 1] * j[2, 2]
    a02 = j[0, 1] * j[1, 2] - j[0, 2] * j[1, 1]
    a10 = j[1, 2] * j[2, 0] - j[1, 0] * j[2, 2]
    a11 = j[0, 0] * j[2, 2] - j[0, 2] * j[2, 0]
    a12 = j[0, 2] * j[1, 0] - j[0, 0] * j[1, 2]
    a20 = j[1, 0] * j[2, 1] - j[1, 1] * j[2, 0]
    a21 = j[0, 1] * j[2, 0] - j[0, 0] * j[2, 1]
    a22 = j[0, 0] * j[1, 1] - j[0, 1] * j[1, 0]
    determinant = j[0, 0] * a00 + j[0, 1] * a10 + j[0, 2] * a20
    for k in range(len(nodes)):
        x, y, z = slopes[k, 0] / determinant, slopes[k, 1] / determinant, slopes[k, 2] / determinant
        out[k, 0] = x * a00 + y * a10 + z * a20
        out[k, 1] = x * a01 + y * a11 + z * a21
        out[k, 2] = x * a02 + y * a12 + z * a22
    return determinant


@lean_kernel
def add_stiffness(grads, stiffness, weight, product, out):
    """Add weight * B^T C B to the upper triangle of `out` (3k, 3k), block rows by node.

    grads (k, 3): from `gradients`; product (6, 3k): scratch.
    """
    width = 3 * len(grads)
    for b in range(len(grads)):
        x, y, z = weight * grads[b, 0], weight * grads[b, 1], weight * grads[b, 2]
        for row in range(6):
            c = stiffness[row]
            product[row, 3 * b] = x * c[0] + y * c[3] + z * c[4]
            product[row, 3 * b + 1] = y * c[1] + x * c[3] + z * c[5]
            product[row, 3 * b + 2] = z * c[2] + x * c[4] + y * c[5]
    for a in range(len(grads)):
        x, y, z = grads[a, 0], grads[a, 1], grads[a, 2]
        for column in range(3 * a, width):
            p = product[:, column]
            out[3 * a, column] += x * p[0] + y * p[3] + z * p[4]
            out[3 * a + 1, column] += y * p[1] + x * p[3] + z * p[5]
            out[3 * a + 2, column] += z * p[2] + x * p[4] + y * p[5]


@kernel
def internal_forces(
    points, tets, part, stiffness, slopes, weights, displacement, free, values, temperature
):
    """Return the forces (n, 3) that the nodes must exert on the elements for this displacement (n, 3).

    part (m,): row of each element in `stiffness` (g, 6, 6) and in `free` (g, 6), the stress-free strains
    with engineering shears; temperature (n,): factor of these, interpolated by shape functions `values` (q,
    k).
    """
    forces = np.zeros((len(points), 3))
    grads, inverse = np.empty((tets.shape[1], 3)), np.empty((3, 3))
    strain = np.empty(6)
    for tet in range(len(tets)):
        nodes, own = tets[tet], part[tet]
        for q in range(len(weights)):
            weight = weights[q] * gradients(points, nodes, slopes[q], inverse, grads)
            _fill_strain(grads, nodes, displacement, strain)
            heat = 0.0
            for k in range(len(nodes)):
                heat += values[q, k] * temperature[nodes[k]]
            strain -= heat * free[own]
            _add_forces(grads, nodes, stiffness[own], strain, weight, forces)
    return forces


@lean_kernel
def _fill_strain(grads, nodes, displacement, out):
    """Fill `out` (6,) with the strain, with engineering shears, at the point of the gradients (k, 3)."""
    out[:] = 0.0
    for k in range(len(nodes)):
        u, v, w = displacement[nodes[k], 0], displacement[nodes[k], 1], displacement[nodes[k], 2]
        x, y, z = grads[k, 0], grads[k, 1], grads[k, 2]
        out[0] += x * u
        out[1] += y * v
        out[2] += z * w
        out[3] += y * u + x * v
        out[4] += z * u + x * w
        out[5] += z * v + y * w


@kernel
def _add_forces(grads, nodes, stiffness, strain, weight, forces):
    s = np.zeros(6)
    for row in range(6):
        for column in range(6):
            s[row] += stiffness[row, column] * strain[column]
    for k in range(len(nodes)):
        x, y, z = weight * grads[k, 0], weight * grads[k, 1], weight * grads[k, 2]
        node = nodes[k]
        forces[node, 0] += x * s[0] + y * s[3] + z * s[4]
        forces[node, 1] += y * s[1] + x * s[3] + z * s[5]
        forces[node, 2] += z * s[2] + x * s[4] + y * s[5]
