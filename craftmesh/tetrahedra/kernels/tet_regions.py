"""Regions of tetrahedra that facets separate, and the volume of all tetrahedra."""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cavity import facet_at


@lean_kernel
def find_facets(tets, facets, count, facet):
    """Write to `facet` (m, 4) the row of the facet on the face opposite each corner, -1 for none.

    facets (f, 3): node ids, all under `count`, as sorted triples in lexicographic order.
    """
    for t in range(len(tets)):
        for k in range(4):
            facet[t, k] = -1
            a, b, c = tets[t, (k + 1) & 3], tets[t, (k + 2) & 3], tets[t, (k + 3) & 3]
            if a < count and b < count and c < count:
                facet[t, k] = facet_at(tets, t, k, facets)


@lean_kernel
def part_regions(neighbours, facet, region, stack):
    """Write the number (m,) of each tet's region; return the number of regions.

    A region is a set of tets connected over faces that are no facets. Regions are numbered from 0 in the
    order of their first tets. facet (m, 4): >= 0 on faces that separate
    regions; stack (m,): work array.
    """
    region[:] = -1
    count = 0
    for seed in range(len(region)):
        if region[seed] >= 0:
            continue
        region[seed], stack[0], height = count, seed, 1
        while height > 0:
            height -= 1
            t = stack[height]
            for k in range(4):
                u = neighbours[t, k]
                if u >= 0 and facet[t, k] < 0 and region[u] < 0:
                    region[u], stack[height] = count, u
                    height += 1
        count += 1
    return count


@lean_kernel
def sum_volumes(points, tets):
    """Return the volume of all tets, and the number of tets whose volume is not positive."""
    total, wrong = 0.0, 0
    for t in range(len(tets)):
        a, b, c, d = tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        wx, wy, wz = points[d, 0] - points[a, 0], points[d, 1] - points[a, 1], points[d, 2] - points[a, 2]
        volume6 = ux * (vy * wz - vz * wy) - uy * (vx * wz - vz * wx) + uz * (vx * wy - vy * wx)
        total += volume6
        wrong += not volume6 > 0.0
    return total / 6.0, wrong
