"""The segments between labels on the faces of a cell, and triangulations of polygons of segments.

The segments on a face depend only on its four labels, so the two cells that share the face agree:

    corners in cyclic order | segments
    AAAA                    | none
    AABB, ABBB              | one, between the two edge points
    ABAB                    | two, cutting off the corners of the larger label (the smaller one bridges)
    ABAC                    | two, cutting off B and C (A bridges)
    AABC, ABCD              | from a face point to the three or four edge points

(M. Wu, J. M. Sullivan, Multiple material marching cubes algorithm, Int. J. Numer. Meth. Eng. 58, 2003.)
A segment is a row (tail, head, right, left): two local points, and the labels on its right and left seen
from outside the cell, with right < left. A facet (tail, head, point inside) has its normal toward `left`.
"""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.remeshing.kernels.cell_tables import FACE_CORNERS, FACE_EDGES, FIRST_FACE_POINT, POINT_FACES

IMPOSSIBLE = 1e30


@lean_kernel
def add_segment(segments, count, tail, head, right, left):
    """Append a segment with its smaller label on the right; return the new count of segments."""
    row = segments[count]
    if right < left:
        row[0], row[1], row[2], row[3] = tail, head, right, left
    else:
        row[0], row[1], row[2], row[3] = head, tail, left, right
    return count + 1


@lean_kernel
def face_segments(labels, face, segments, count):
    """Append the segments on face 0..5 of a cell with corner labels (8,); return the new count."""
    corner, edge = FACE_CORNERS[face], FACE_EDGES[face]
    changes, first, last = 0, -1, -1
    for i in range(4):
        if labels[corner[i]] != labels[corner[(i + 1) & 3]]:
            first = i if changes == 0 else first
            last = i
            changes += 1
    if changes == 0:
        return count
    if changes == 2:
        right, left = labels[corner[first + 1]], labels[corner[first]]
        return add_segment(segments, count, edge[first], edge[last], right, left)
    a, b, c, d = labels[corner[0]], labels[corner[1]], labels[corner[2]], labels[corner[3]]
    if a == c or b == d:
        cut = 1 if a == c and (b != d or a < b) else 0
        for i in (cut, cut + 2):
            before = (i + 3) & 3
            right, left = labels[corner[i]], labels[corner[before]]
            count = add_segment(segments, count, edge[before], edge[i], right, left)
        return count
    for i in range(4):
        right, left = labels[corner[i]], labels[corner[(i + 1) & 3]]
        if right != left:
            count = add_segment(segments, count, FIRST_FACE_POINT + face, edge[i], right, left)
    return count


@lean_kernel
def _badness(p, q, r):
    """Return the sum of squared edges divided by twice the area: small for well-shaped triangles."""
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    wx, wy, wz = vx - ux, vy - uy, vz - uz
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    edges = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
    return edges / max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-6)


@lean_kernel
def _best_splits(polygon, n, at, cost, split):
    """Fill `cost` and `split` by dynamic programming; cost[0, n - 1] is the cost of the whole polygon.

    A diagonal in a face of the cell is excluded, because the neighbour may use it for other facets. at:
    positions of local points; split[i, j]: the third corner of the triangle on the diagonal from i to j.
    """
    for i in range(n - 1):
        cost[i, i + 1] = 0.0
    for span in range(2, n):
        for i in range(n - span):
            j = i + span
            cost[i, j] = IMPOSSIBLE
            if span < n - 1 and POINT_FACES[polygon[i]] & POINT_FACES[polygon[j]]:
                continue
            for k in range(i + 1, j):
                total = cost[i, k] + cost[k, j]
                if total < IMPOSSIBLE:
                    total += _badness(at[polygon[i]], at[polygon[k]], at[polygon[j]])
                    if total < cost[i, j]:
                        cost[i, j] = total
                        split[i, j] = k


@lean_kernel
def triangulate(polygon, n, at, scratch, triangles):
    """Write the best triangulation of a polygon of n local points to `triangles`; return their number.

    The number is 0 if every triangulation needs a diagonal in a face of the cell.
    """
    cost, split, stack = scratch.cost, scratch.split, scratch.stack
    _best_splits(polygon, n, at, cost, split)
    if cost[0, n - 1] >= IMPOSSIBLE:
        return 0
    stack[0, 0], stack[0, 1] = 0, n - 1
    waiting, count = 1, 0
    while waiting:
        waiting -= 1
        i, j = stack[waiting, 0], stack[waiting, 1]
        if j - i < 2:
            continue
        k = split[i, j]
        triangles[count, 0], triangles[count, 1], triangles[count, 2] = polygon[i], polygon[k], polygon[j]
        count += 1
        stack[waiting, 0], stack[waiting, 1] = i, k
        stack[waiting + 1, 0], stack[waiting + 1, 1] = k, j
        waiting += 2
    return count
