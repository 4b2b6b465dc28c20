"""Measures of the shape of tetrahedra: volume, aspect ratio, extreme dihedral angles, shape factor."""

import numpy as np

from craftmesh.jit import lean_kernel

# Factor of R^3, R the radius of the circumsphere, in the regular tetrahedron's volume.
REGULAR = 8.0 * np.sqrt(3.0) / 27.0


@lean_kernel
def _cosine(one, other, areas):
    """Return the cosine of the dihedral angle between two faces with inward normals `one` and `other`.

    areas: product of the normals' lengths; 0 gives 1.
    """
    if areas == 0.0:
        return 1.0
    inner = one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
    return min(max(-inner / areas, -1.0), 1.0)


@lean_kernel
def fill_measures(points, tets, measures):
    """Write the measures (m, 5) of the tets (m, 4), the columns of `shape_measures`."""
    for t in range(len(tets)):
        a, b, c, d = tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        wx, wy, wz = points[d, 0] - points[a, 0], points[d, 1] - points[a, 1], points[d, 2] - points[a, 2]
        rx, ry, rz = vx - ux, vy - uy, vz - uz
        sx, sy, sz = wx - ux, wy - uy, wz - uz
        # normals of the faces, twice their areas long: `of_d` belongs to the face opposite d
        of_d = (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
        of_c = (wy * uz - wz * uy, wz * ux - wx * uz, wx * uy - wy * ux)
        of_b = (vy * wz - vz * wy, vz * wx - vx * wz, vx * wy - vy * wx)
        of_a = (sy * rz - sz * ry, sz * rx - sx * rz, sx * ry - sy * rx)
        area_a = np.sqrt(of_a[0] ** 2 + of_a[1] ** 2 + of_a[2] ** 2)
        area_b = np.sqrt(of_b[0] ** 2 + of_b[1] ** 2 + of_b[2] ** 2)
        area_c = np.sqrt(of_c[0] ** 2 + of_c[1] ** 2 + of_c[2] ** 2)
        area_d = np.sqrt(of_d[0] ** 2 + of_d[1] ** 2 + of_d[2] ** 2)
        cosines = (
            _cosine(of_a, of_b, area_a * area_b),
            _cosine(of_a, of_c, area_a * area_c),
            _cosine(of_a, of_d, area_a * area_d),
            _cosine(of_b, of_c, area_b * area_c),
            _cosine(of_b, of_d, area_b * area_d),
            _cosine(of_c, of_d, area_c * area_d),
        )
        ab, ac, ad = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz
        bc, bd = rx * rx + ry * ry + rz * rz, sx * sx + sy * sy + sz * sz
        cd = (wx - vx) ** 2 + (wy - vy) ** 2 + (wz - vz) ** 2
        six_volume = of_d[0] * wx + of_d[1] * wy + of_d[2] * wz
        size = abs(six_volume)
        measures[t, 0] = six_volume / 6.0
        measures[t, 1], measures[t, 4] = np.inf, 0.0
        measures[t, 2] = np.degrees(np.arccos(max(cosines)))
        measures[t, 3] = np.degrees(np.arccos(min(cosines)))
        if size > 0.0:
            longest = np.sqrt(max(ab, ac, ad, bc, bd, cd))
            measures[t, 1] = longest * max(area_a, area_b, area_c, area_d) / size
            x, y, z = np.sqrt(ab * cd), np.sqrt(ac * bd), np.sqrt(ad * bc)
            # 24 R V by Crelle's formula
            crelle = np.sqrt(max((x + y + z) * (x + y - z) * (x - y + z) * (y + z - x), 0.0))
            cube = (crelle / (4.0 * size)) ** 3
            measures[t, 4] = size / (6.0 * REGULAR * cube) if cube > 0.0 else np.inf
