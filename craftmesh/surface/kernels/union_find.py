"""Union-find: the root of the piece that an element belongs to."""

from craftmesh.jit import lean_kernel


@lean_kernel
def root_of(parent, element):
    """Return the root of an element, whose parent is the root itself; the way to it gets shorter.

    parent (n,): another element of the same piece, for each element.
    """
    while parent[element] != element:
        parent[element] = parent[parent[element]]
        element = parent[element]
    return element
