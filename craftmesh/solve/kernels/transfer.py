"""Between the corners of the elements and all nodes: linear along each edge.

Corner k is node corner[k]; mid node mid[k] lies between the corners ends[k] (two rows of `corner`), a share
of the way from the first to the second.
"""

from craftmesh.jit import lean_kernel


@lean_kernel
def to_nodes(corner, mid, ends, share, fixed, coarse, out):
    """Fill `out` (n, 3) with the values of the corners `coarse` (c, 3) and between them; 0 where fixed."""
    for k in range(len(corner)):
        for r in range(3):
            out[corner[k], r] = 0.0 if fixed[corner[k], r] else coarse[k, r]
    for k in range(len(mid)):
        a, b = ends[k]
        for r in range(3):
            value = (1.0 - share[k]) * coarse[a, r] + share[k] * coarse[b, r]
            out[mid[k], r] = 0.0 if fixed[mid[k], r] else value


@lean_kernel
def to_corners(corner, mid, ends, share, fixed, fine, out):
    """Fill `out` (c, 3) by the transpose of `to_nodes`, with 0 at the corners' fixed components."""
    for k in range(len(corner)):
        for r in range(3):
            out[k, r] = 0.0 if fixed[corner[k], r] else fine[corner[k], r]
    for k in range(len(mid)):
        a, b = ends[k]
        for r in range(3):
            if not fixed[mid[k], r]:
                if not fixed[corner[a], r]:
                    out[a, r] += (1.0 - share[k]) * fine[mid[k], r]
                if not fixed[corner[b], r]:
                    out[b, r] += share[k] * fine[mid[k], r]
