"""Shape of tetrahedra, one pass over millions of them."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel


@lean_kernel
def _face(points, a, b, c):
    """Return twice the area vector of the triangle a, b, c, and its length."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return x, y, z, np.sqrt(x * x + y * y + z * z)


@lean_kernel
def _length(points, a, b):
    x, y, z = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1], points[a, 2] - points[b, 2]
    return np.sqrt(x * x + y * y + z * z)


@lean_kernel
def _cosine(first, second):
    """Return the cosine of the dihedral angle between two faces whose normals point out of the tet."""
    areas = first[3] * second[3]
    if areas <= 0:
        return 1.0
    cosine = -(first[0] * second[0] + first[1] * second[1] + first[2] * second[2]) / areas
    return min(max(cosine, -1.0), 1.0)


@lean_kernel
def _circumradius_times_volume(x, y, z):
    """Return 24 R V from the products of the lengths of opposite edges (Crelle's formula)."""
    return np.sqrt(max((x + y + z) * (x + y - z) * (x - y + z) * (-x + y + z), 0.0))


@kernel
def shape_measures(points, tets):
    """Return (m, 5): volume, aspect ratio, smallest and largest dihedral in degrees, shape factor.

    Aspect ratio: longest edge over smallest altitude; infinite for a flat element. Shape factor:
    volume over that of the regular tetrahedron with the same circumsphere; 0 when flat.
    """
    out = np.empty((len(tets), 5))
    for t in range(len(tets)):
        a, b, c, d = tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3]
        p, q = _face(points, a, c, b), _face(points, a, b, d)
        r, s = _face(points, b, c, d), _face(points, c, a, d)
        ab, bc, ca = _length(points, a, b), _length(points, b, c), _length(points, c, a)
        ad, bd, cd = _length(points, a, d), _length(points, b, d), _length(points, c, d)
        x, y, z = points[d, 0] - points[a, 0], points[d, 1] - points[a, 1], points[d, 2] - points[a, 2]
        six_volume = -(p[0] * x + p[1] * y + p[2] * z)
        size = abs(six_volume)
        pq, pr, ps, qr, qs, rs = (
            _cosine(p, q),
            _cosine(p, r),
            _cosine(p, s),
            _cosine(q, r),
            _cosine(q, s),
            _cosine(r, s),
        )
        out[t, 0] = six_volume / 6
        out[t, 1], out[t, 4] = np.inf, 0.0
        out[t, 2] = np.degrees(np.arccos(max(pq, pr, ps, qr, qs, rs)))
        out[t, 3] = np.degrees(np.arccos(min(pq, pr, ps, qr, qs, rs)))
        if size > 0:
            radius = _circumradius_times_volume(ab * cd, bc * ad, ca * bd) / (4 * size)
            out[t, 1] = max(ab, bc, ca, ad, bd, cd) * max(p[3], q[3], r[3], s[3]) / size
            out[t, 4] = size / 6 / (8 * np.sqrt(3.0) / 27 * radius**3)
    return out
