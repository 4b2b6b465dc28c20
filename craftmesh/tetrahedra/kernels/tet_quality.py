"""Quality of tetrahedra: kernels for the optimiser, on one tet at a time.

A tet is three nodes a, b, c and a fourth corner at (x, y, z), with positive volume when a, b, c turn
right-handed towards it.
"""

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.mesh.shape_measures import LEAST_SHAPE_FACTOR

# Measures of quality: see `quality_at`.
VOLUME_LENGTH, ANGLE_QUALITY, SHAPE_QUALITY, COMBINED_QUALITY = range(4)
INVERTED = 1e300
# Volume-length quality below which a tet counts as flat.
FLAT = 1e-9
ROOT2 = np.sqrt(2.0)
# Aspect ratio above which a tet counts as stretched.
STRETCHED = 5.0
# Quality by ANGLE_QUALITY or SHAPE_QUALITY below which a tet counts as poor. These measures are at most
# the sine of each acute dihedral angle and half the sine of each obtuse one, so from POOR on all angles lie
# in 10..160 degrees: sin 10 deg is .1736, half of sin 160 deg is .1710. A tet of higher quality by
# SHAPE_QUALITY is not poor by `mesh/shape_measures`; one of higher quality by ANGLE_QUALITY does not exceed
# the aspect ratio STRETCHED.
POOR = 0.174
# Quality by SHAPE_QUALITY, a little over sin 15 deg, from which all dihedral angles lie in 15..149 degrees.
WIDE = 0.26
RATIO_SCALE, FACTOR_SCALE = POOR * STRETCHED, POOR / LEAST_SHAPE_FACTOR
# The shape factor is V / (8 sqrt3 / 27 R^3): with R = around / (24 V), this times (24 V)^4 / around^3.
FACTOR_OF_FOURTH = 27.0 / (24.0 * 8.0 * np.sqrt(3.0))


@lean_kernel
def _sine(volume6, length2, area_i, area_j, cosine):
    """Return the sine of the dihedral angle at an edge; half the sine if the angle is obtuse.

    length2: the edge's squared length; area_i, area_j: twice the areas of its two faces; cosine: product of
    their outward normals, negative for an acute angle.
    """
    sine = volume6 * np.sqrt(length2) / (area_i * area_j)
    return sine if cosine < 0.0 else 0.5 * sine


@lean_kernel
def _shape_factor(volume6, products):
    """Return the shape factor: the volume divided by the regular tet's with the same circumsphere.

    volume6: six times the volume; products (3): products of the squared lengths of opposite edges.
    """
    x, y, z = np.sqrt(products[0]), np.sqrt(products[1]), np.sqrt(products[2])
    # 24 R V, squared (Crelle's formula)
    around2 = (x + y + z) * (x + y - z) * (x - y + z) * (y + z - x)
    volume24 = 4.0 * volume6
    return FACTOR_OF_FOURTH * volume24**4 / (around2 * np.sqrt(around2)) if around2 > 0.0 else 0.0


@lean_kernel
def quality_at(points, a, b, c, x, y, z, measure):
    """Return the quality of the tet a, b, c, (x, y, z) by a measure: <= 0 if flat or inverted.

    VOLUME_LENGTH: 6 sqrt2 V / l_rms^3, 1 for the regular tet. ANGLE_QUALITY: the minimum of *angles* and
    .87 h_min / l_max, where *angles* is the minimum of the sines of acute dihedral angles and half the
    sines of obtuse ones; from .174 on, angles lie in 10..160 degrees and the aspect ratio is below 5.
    SHAPE_QUALITY: the minimum of *angles* and 8.7 times the shape factor (volume over the regular tet's
    with the same circumsphere). COMBINED_QUALITY: SHAPE_QUALITY if SHAPE_QUALITY is under POOR, else .174
    plus the minimum of ANGLE_QUALITY and SHAPE_QUALITY. So a poor tet is below all others, and from .348 on
    a tet is neither poor nor of an aspect ratio over 5.
    """
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    wx, wy, wz = x - points[a, 0], y - points[a, 1], z - points[a, 2]
    volume6 = ux * (vy * wz - vz * wy) - uy * (vx * wz - vz * wx) + uz * (vx * wy - vy * wx)
    rx, ry, rz = vx - ux, vy - uy, vz - uz
    sx, sy, sz = wx - ux, wy - uy, wz - uz
    tx, ty, tz = wx - vx, wy - vy, wz - vz
    ab, ac, ad = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz
    bc, bd, cd = rx * rx + ry * ry + rz * rz, sx * sx + sy * sy + sz * sz, tx * tx + ty * ty + tz * tz
    mean = (ab + ac + ad + bc + bd + cd) / 6.0
    if mean == 0.0:
        return 0.0
    volume_length = ROOT2 * volume6 / (mean * np.sqrt(mean))
    if measure == VOLUME_LENGTH or volume_length <= FLAT:
        return volume_length
    # Outward normals, twice the areas long: d is the face a, b, c opposite corner d, and so on.
    dx, dy, dz = vy * uz - vz * uy, vz * ux - vx * uz, vx * uy - vy * ux
    cx, cy, cz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    bx, by, bz = wy * vz - wz * vy, wz * vx - wx * vz, wx * vy - wy * vx
    ax, ay, az = -(bx + cx + dx), -(by + cy + dy), -(bz + cz + dz)
    area_a, area_b = np.sqrt(ax * ax + ay * ay + az * az), np.sqrt(bx * bx + by * by + bz * bz)
    area_c, area_d = np.sqrt(cx * cx + cy * cy + cz * cz), np.sqrt(dx * dx + dy * dy + dz * dz)
    angles = min(
        _sine(volume6, ab, area_c, area_d, cx * dx + cy * dy + cz * dz),
        _sine(volume6, ac, area_b, area_d, bx * dx + by * dy + bz * dz),
        _sine(volume6, ad, area_b, area_c, bx * cx + by * cy + bz * cz),
        _sine(volume6, bc, area_a, area_d, ax * dx + ay * dy + az * dz),
        _sine(volume6, bd, area_a, area_c, ax * cx + ay * cy + az * cz),
        _sine(volume6, cd, area_a, area_b, ax * bx + ay * by + az * bz),
    )
    worst = angles
    if measure != ANGLE_QUALITY:
        worst = min(angles, FACTOR_SCALE * _shape_factor(volume6, (ab * cd, ac * bd, ad * bc)))
    if measure == SHAPE_QUALITY or (measure == COMBINED_QUALITY and worst < POOR):
        return worst
    longest = max(ab, ac, ad, bc, bd, cd)
    ratio = RATIO_SCALE * volume6 / (max(area_a, area_b, area_c, area_d) * np.sqrt(longest))
    return min(worst, ratio) + (POOR if measure == COMBINED_QUALITY else 0.0)


@lean_kernel
def quality_of(points, a, b, c, d, measure):
    """Return the quality of the tet a, b, c, d: see `quality_at`."""
    return quality_at(points, a, b, c, points[d, 0], points[d, 1], points[d, 2], measure)


@lean_kernel
def _area2(x, y, z):
    """Return four times a triangle's squared area, from the squares of its edges (Heron's formula)."""
    return x * y - 0.25 * (x + y - z) ** 2


@lean_kernel
def aspect_ratio_over(points, a, b, c, x, y, z, floor):
    """Return the aspect ratio of the tet a, b, c, (x, y, z): longest edge over smallest altitude.

    The ratio is INVERTED if the volume-length quality is not over `floor`.
    """
    ux, uy, uz = points[a, 0] - x, points[a, 1] - y, points[a, 2] - z
    vx, vy, vz = points[b, 0] - x, points[b, 1] - y, points[b, 2] - z
    wx, wy, wz = points[c, 0] - x, points[c, 1] - y, points[c, 2] - z
    volume6 = wx * (uz * vy - uy * vz) + wy * (ux * vz - uz * vx) + wz * (uy * vx - ux * vy)
    u2, v2, w2 = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz
    uv = (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2
    vw = (vx - wx) ** 2 + (vy - wy) ** 2 + (vz - wz) ** 2
    wu = (wx - ux) ** 2 + (wy - uy) ** 2 + (wz - uz) ** 2
    mean = (u2 + v2 + w2 + uv + vw + wu) / 6.0
    if ROOT2 * volume6 <= floor * mean * np.sqrt(mean):
        return INVERTED
    largest = max(_area2(u2, v2, uv), _area2(v2, w2, vw), _area2(w2, u2, wu), _area2(uv, vw, wu))
    return np.sqrt(largest * max(u2, v2, w2, uv, vw, wu)) / volume6


@lean_kernel
def aspect_ratio_at(points, a, b, c, x, y, z):
    """Return the aspect ratio l_max / h_min of the tet a, b, c, (x, y, z); INVERTED if flat or inverted."""
    return aspect_ratio_over(points, a, b, c, x, y, z, FLAT)


@lean_kernel
def aspect_ratio_of(points, a, b, c, d):
    """Return the aspect ratio of the tet a, b, c, d: see `aspect_ratio_at`."""
    return aspect_ratio_at(points, a, b, c, points[d, 0], points[d, 1], points[d, 2])


@lean_kernel
def all_qualities(points, tets, count, quality, measure):
    """Write the qualities of the live tets among the first `count`; dead tets have first corner -1."""
    for t in range(count):
        if tets[t, 0] >= 0:
            quality[t] = quality_of(points, tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3], measure)


@lean_kernel
def all_aspect_ratios(points, tets, count, ratio):
    """Write the aspect ratios of the live tets among the first `count`, 0 for dead ones."""
    for t in range(count):
        ratio[t] = 0.0
        if tets[t, 0] >= 0:
            ratio[t] = aspect_ratio_of(points, tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3])
