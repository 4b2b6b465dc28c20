"""Aspect ratios of the tets that join one point to given faces, many tets at a time.

Quantities that do not depend on the point, the apex, are in a table with a column for each face, so that
the loop over faces is vectorised. The areas of the other faces follow from squared edge lengths. For 24
tets a sum takes 32 ns, but a loop over `aspect_ratio_at` 280 ns.
"""

from collections import namedtuple

import numpy as np

from craftmesh.jit import lean_kernel, vector_kernel
from craftmesh.tetrahedra.kernels.tet_quality import INVERTED

# The first `count` columns of a table (TABLE_ROWS, f), a work array for their values, and the volume-length
# quality, at least FLAT, that a tet must exceed.
RatioCone = namedtuple("RatioCone", "table values count limit")
# Smallest number of columns that a vectorised loop computes at once.
LANES = 8
# Rows of a table: the corners and the normal of a face a, b, c (three rows each), the squares of its edges,
# of its normal, and of its longest edge.
A, B, C, NORMAL, AB2, BC2, CA2, NORMAL2, LONGEST2, TABLE_ROWS = 0, 3, 6, 9, 12, 13, 14, 15, 16, 17


@lean_kernel
def filled(count):
    """Return `count` rounded up to a multiple of LANES.

    A vectorised loop takes as long for the rest of a vector as for a full one.
    """
    return (count + LANES - 1) // LANES * LANES


@lean_kernel
def fill_table(points, faces, count, table):
    """Fill the table (TABLE_ROWS, f) for the first `count` faces (f, 3).

    Each tet of face and apex must have a positive volume. Columns from `count` to `filled(count)` repeat
    the last face, so that whole vectors hold valid numbers; sums leave them out.
    """
    for i in range(count):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        for k in range(3):
            table[A + k, i], table[B + k, i], table[C + k, i] = points[a, k], points[b, k], points[c, k]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        table[NORMAL, i], table[NORMAL + 1, i], table[NORMAL + 2, i] = nx, ny, nz
        ab, ca = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
        bc = (vx - ux) ** 2 + (vy - uy) ** 2 + (vz - uz) ** 2
        table[AB2, i], table[BC2, i], table[CA2, i] = ab, bc, ca
        table[NORMAL2, i] = nx * nx + ny * ny + nz * nz
        table[LONGEST2, i] = max(ab, bc, ca)
    for i in range(count, filled(count)):
        for row in range(TABLE_ROWS):
            table[row, i] = table[row, count - 1]


@vector_kernel
def _fill_ratios(table, ratios, count, limit, x, y, z):
    """Write the aspect ratios of the tets that join the table's faces to the apex (x, y, z) to `ratios`.

    A ratio is INVERTED if the tet's volume-length quality is not over `limit`.
    """
    for i in range(count):
        ux, uy, uz = table[A, i] - x, table[A + 1, i] - y, table[A + 2, i] - z
        vx, vy, vz = table[B, i] - x, table[B + 1, i] - y, table[B + 2, i] - z
        wx, wy, wz = table[C, i] - x, table[C + 1, i] - y, table[C + 2, i] - z
        volume6 = -(table[NORMAL, i] * ux + table[NORMAL + 1, i] * uy + table[NORMAL + 2, i] * uz)
        u2 = ux * ux + uy * uy + uz * uz
        v2 = vx * vx + vy * vy + vz * vz
        w2 = wx * wx + wy * wy + wz * wz
        uv, vw, wu = u2 + v2 - table[AB2, i], v2 + w2 - table[BC2, i], w2 + u2 - table[CA2, i]
        sides = max(4.0 * u2 * v2 - uv * uv, 4.0 * v2 * w2 - vw * vw, 4.0 * w2 * u2 - wu * wu)
        largest = max(0.25 * sides, table[NORMAL2, i])
        longest = max(u2, v2, w2, table[LONGEST2, i])
        mean = (u2 + v2 + w2 + table[AB2, i] + table[BC2, i] + table[CA2, i]) / 6.0
        ratio = np.sqrt(largest * longest) / volume6
        is_over = volume6 > 0.0 and 2.0 * volume6 * volume6 > limit * limit * mean * mean * mean
        ratios[i] = ratio if is_over else INVERTED


@lean_kernel
def ratio_sum(cone, x, y, z):
    """Return the sum of the aspect ratios of the cone's tets with the apex at (x, y, z).

    It is INVERTED or more if a tet's volume-length quality is not over cone.limit.
    """
    _fill_ratios(cone.table, cone.values, filled(cone.count), cone.limit, x, y, z)
    total = 0.0
    for i in range(cone.count):
        total += cone.values[i]
    return total
