"""Aspect ratios and qualities of the tets that join one point to given faces, many tets at a time.

What does not change with the point stands in a table whose columns are the faces, so that the loop over
these is vectorised. The areas of the other faces come from squares of edges alone: for 24 tets a sum takes
32 ns, a loop over `aspect_ratio_at` 280.
"""

from collections import namedtuple

import numpy as np

from craftmesh.jit import lean_kernel, vector_kernel
from craftmesh.tetrahedra.kernels.tet_quality import FLAT, INVERTED, ROOT2

# The first `count` columns of a table (TABLE_ROWS, f), and room for a value of each.
RatioCone = namedtuple("RatioCone", "table values count")
# Rows of a table: the corners and the normal of a face a, b, c (three rows each), the squares of its edges,
# of its normal, and of its longest edge.
A, B, C, NORMAL, AB2, BC2, CA2, NORMAL2, LONGEST2, TABLE_ROWS = 0, 3, 6, 9, 12, 13, 14, 15, 16, 17


@lean_kernel
def fill_table(points, faces, count, table):
    """Fill the table (TABLE_ROWS, f) for the first `count` faces (f, 3), each positive with the apex."""
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


@lean_kernel
def _tet(table, i, x, y, z):
    """Return the ways from (x, y, z) to the corners of face `i`, and six times the volume of its tet."""
    ux, uy, uz = table[A, i] - x, table[A + 1, i] - y, table[A + 2, i] - z
    volume6 = -(table[NORMAL, i] * ux + table[NORMAL + 1, i] * uy + table[NORMAL + 2, i] * uz)
    v = (table[B, i] - x, table[B + 1, i] - y, table[B + 2, i] - z)
    w = (table[C, i] - x, table[C + 1, i] - y, table[C + 2, i] - z)
    return (ux, uy, uz), v, w, volume6


@vector_kernel
def _fill_ratios(table, ratios, count, x, y, z):
    """Write the aspect ratios l_max / h_min of the tets with apex (x, y, z); INVERTED for flat ones."""
    for i in range(count):
        (ux, uy, uz), (vx, vy, vz), (wx, wy, wz), volume6 = _tet(table, i, x, y, z)
        u2 = ux * ux + uy * uy + uz * uz
        v2 = vx * vx + vy * vy + vz * vz
        w2 = wx * wx + wy * wy + wz * wz
        uv, vw, wu = u2 + v2 - table[AB2, i], v2 + w2 - table[BC2, i], w2 + u2 - table[CA2, i]
        sides = max(4.0 * u2 * v2 - uv * uv, 4.0 * v2 * w2 - vw * vw, 4.0 * w2 * u2 - wu * wu)
        largest = max(0.25 * sides, table[NORMAL2, i])
        longest = max(u2, v2, w2, table[LONGEST2, i])
        ratio = np.sqrt(largest * longest) / volume6
        ratios[i] = ratio if volume6 > FLAT * longest * np.sqrt(longest) else INVERTED


@vector_kernel
def _fill_volume_lengths(table, values, count, x, y, z):
    """Write the volume-length qualities (`quality_at`) of the tets with apex (x, y, z)."""
    for i in range(count):
        (ux, uy, uz), (vx, vy, vz), (wx, wy, wz), volume6 = _tet(table, i, x, y, z)
        squares = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
        mean = (squares + table[AB2, i] + table[BC2, i] + table[CA2, i]) / 6.0
        values[i] = ROOT2 * volume6 / (mean * np.sqrt(mean))


@lean_kernel
def ratio_sum(cone, x, y, z):
    """Sum of the cone's aspect ratios from (x, y, z); INVERTED at least with a tet that is flat."""
    _fill_ratios(cone.table, cone.values, cone.count, x, y, z)
    total = 0.0
    for i in range(cone.count):
        total += cone.values[i]
    return total


@lean_kernel
def least_volume_length(cone, x, y, z):
    """Worst volume-length quality of the cone from (x, y, z)."""
    _fill_volume_lengths(cone.table, cone.values, cone.count, x, y, z)
    least = cone.values[0]
    for i in range(1, cone.count):
        least = min(least, cone.values[i])
    return least
