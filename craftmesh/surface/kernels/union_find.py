"""Union-find: the root of the piece that an element belongs to."""

from craftmesh.jit import lean_kernel


@lean_kernel
def root_of(parent, element):
    """Return the root of an element, which is its own parent; the path to it is shortened.

    parent (n,): for each element, another element of the same piece, or itself.
    """
    while parent[element] != element:
        parent[element] = parent[parent[element]]
        element = parent[element]
    return element
