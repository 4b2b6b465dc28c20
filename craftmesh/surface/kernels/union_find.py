"""Union-find: the root of the piece that an element belongs to, and the pieces of all."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel


@lean_kernel
def root_of(parent, element):
    """Return the root of an element: the element of its piece that is its own parent.

    The path to the root is shortened in place.

    parent (n,): for each element, another element of the same piece, or itself.
    """
    while parent[element] != element:
        parent[element] = parent[parent[element]]
        element = parent[element]
    return element


@kernel
def pieces_of(count, one, other):
    """Return the piece (count,) of each element, where pairs one[i], other[i] are linked.

    Pieces are numbered from 0 in the order of their first elements.
    """
    parent, piece = np.arange(count), np.empty(count, np.int64)
    for i in range(len(one)):
        a, b = root_of(parent, one[i]), root_of(parent, other[i])
        parent[max(a, b)] = min(a, b)
    found = 0
    for element in range(count):
        root = root_of(parent, element)
        piece[element] = found if root == element else piece[root]
        found += root == element
    return piece
