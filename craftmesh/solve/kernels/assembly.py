"""The stiffness matrix by nodes: blocks of 3 x 3 on and above the diagonal.

start (n + 1,), column (k,): row i has blocks in the columns of the nodes column[start[i] : start[i + 1]],
all greater than i, ascending; blocks on the diagonal are stored apart.
"""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.solve.kernels.elements import add_stiffness, gradients


@kernel
def assemble_blocks(points, tets, part, stiffness, slopes, weights, start, column):
    """Return the blocks on (n, 3, 3) and above (k, 3, 3) the diagonal of the stiffness matrix.

    part (m,): row of each element in `stiffness` (g, 6, 6); slopes, weights: see `elements`.
    """
    diagonal, upper = np.zeros((len(points), 3, 3)), np.zeros((len(column), 3, 3))
    width = tets.shape[1]
    grads, inverse = np.empty((width, 3)), np.empty((3, 3))
    product, own = np.empty((6, 3 * width)), np.empty((3 * width, 3 * width))
    for tet in range(len(tets)):
        nodes = tets[tet]
        own[:, :] = 0.0
        for q in range(len(weights)):
            weight = weights[q] * gradients(points, nodes, slopes[q], inverse, grads)
            add_stiffness(grads, stiffness[part[tet]], weight, product, own)
        for a in range(width):
            _add_diagonal(own, a, diagonal[nodes[a]])
            for b in range(a + 1, width):
                low, high = min(nodes[a], nodes[b]), max(nodes[a], nodes[b])
                place = _place_of(high, column, start[low], start[low + 1])
                _add_block(own, 3 * a, 3 * b, nodes[a] < nodes[b], upper[place])
    return diagonal, upper


@kernel
def _place_of(node, column, low, high):
    """Return the position of `node` in column[low:high], which ascends and contains it."""
    while high - low > 1:
        middle = (low + high) // 2
        if column[middle] <= node:
            low = middle
        else:
            high = middle
    return low


@lean_kernel
def _add_diagonal(own, a, block):
    for r in range(3):
        for s in range(r, 3):
            value = own[3 * a + r, 3 * a + s]
            block[r, s] += value
            if s > r:
                block[s, r] += value


@lean_kernel
def _add_block(own, row, column, is_upper, block):
    """Add the block of an element's matrix at (row, column), transposed if it lies below the diagonal."""
    if is_upper:
        for r in range(3):
            for s in range(3):
                block[r, s] += own[row + r, column + s]
    else:
        for r in range(3):
            for s in range(3):
                block[s, r] += own[row + r, column + s]
