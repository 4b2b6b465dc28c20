"""The stiffness matrix by nodes: blocks of 3 x 3 on and above the diagonal.

start (n + 1,), column: the row of node i holds the blocks to the nodes column[start[i] : start[i + 1]], all
greater than i, ascending; the blocks on the diagonal lie apart.
"""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.solve.kernels.elements import add_stiffness, gradients


@kernel
def elements_of_nodes(tets, n):
    """Return start (n + 1,) and `tet`: node i is in the elements tet[start[i] : start[i + 1]]."""
    start = np.zeros(n + 1, np.int64)
    for row in tets:
        for node in row:
            start[node + 1] += 1
    for node in range(n):
        start[node + 1] += start[node]
    place = start[:-1].copy()
    owner = np.empty(start[n], np.int32)
    for tet in range(len(tets)):
        for node in tets[tet]:
            owner[place[node]] = tet
            place[node] += 1
    return start, owner


@kernel
def upper_pattern(tets, n):
    """Return start (n + 1,) and column of the blocks above the diagonal, one for each pair of nodes."""
    first, owner = elements_of_nodes(tets, n)
    seen = np.full(n, -1, np.int64)
    start = np.zeros(n + 1, np.int64)
    for node in range(n):
        count = 0
        for place in range(first[node], first[node + 1]):
            for other in tets[owner[place]]:
                if other > node and seen[other] != node:
                    seen[other] = node
                    count += 1
        start[node + 1] = start[node] + count
    column = np.empty(start[n], np.int32)
    seen[:] = -1
    for node in range(n):
        end = start[node]
        for place in range(first[node], first[node + 1]):
            for other in tets[owner[place]]:
                if other > node and seen[other] != node:
                    seen[other] = node
                    column[end] = other
                    end += 1
        column[start[node] : end].sort()
    return start, column


@kernel
def assemble_blocks(points, tets, part, stiffness, slopes, weights, start, column):
    """Return the blocks on (n, 3, 3) and above the diagonal of the stiffness matrix.

    part (m,): the row of each element in `stiffness` (g, 6, 6).
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
    """Return where `node` is in column[low:high], which ascends and holds it."""
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
    """Add the block of an element's matrix at (row, column), or its transpose where that lies above."""
    if is_upper:
        for r in range(3):
            for s in range(3):
                block[r, s] += own[row + r, column + s]
    else:
        for r in range(3):
            for s in range(3):
                block[s, r] += own[row + r, column + s]


@lean_kernel
def take_out(fixed, start, column, diagonal, upper):
    """Set the rows and columns of prescribed displacements, fixed (n, 3), to 0 but on the diagonal.

    A right-hand side that is 0 there then has an answer that is 0 there. A node without an element gets 1.
    """
    for i in range(len(diagonal)):
        _clear(fixed[i], fixed[i], diagonal[i], True)
        for r in range(3):
            if diagonal[i, r, r] == 0.0:
                diagonal[i, r, r] = 1.0
        for place in range(start[i], start[i + 1]):
            _clear(fixed[i], fixed[column[place]], upper[place], False)


@lean_kernel
def _clear(rows, columns, block, is_diagonal):
    for r in range(3):
        for s in range(3):
            if (rows[r] or columns[s]) and not (is_diagonal and r == s):
                block[r, s] = 0.0
