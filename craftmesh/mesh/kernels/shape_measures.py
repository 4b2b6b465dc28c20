"""Shape of tetrahedra, one pass over millions of them."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel


@kernel
def _face_vector(points, a, b, c, out):
    """Set `out` to twice the area vector of the triangle a, b, c; return its length."""
    ux, uy, uz = points[b] - points[a]
    vx, vy, vz = points[c] - points[a]
    out[0] = uy * vz - uz * vy
    out[1] = uz * vx - ux * vz
    out[2] = ux * vy - uy * vx
    return np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)


@lean_kernel
def _length(points, a, b):
    total = 0.0
    for axis in range(3):
        total += (points[a, axis] - points[b, axis]) ** 2
    return np.sqrt(total)


@lean_kernel
def _cosines(face, area):
    """Return the smallest and the largest cosine of the six dihedral angles."""
    low, high = 1.0, -1.0
    for i in range(4):
        for j in range(i):
            product = 0.0
            for axis in range(3):
                product -= face[i, axis] * face[j, axis]
            cosine = product / (area[i] * area[j]) if area[i] * area[j] > 0 else 1.0
            low, high = min(low, cosine), max(high, cosine)
    return max(low, -1.0), min(high, 1.0)


@lean_kernel
def _circumradius_times_volume(edge):
    """Return 24 R V from the lengths of the edges 12, 23, 31, 14, 24, 34 (Crelle's formula)."""
    x, y, z = edge[0] * edge[5], edge[1] * edge[3], edge[2] * edge[4]
    return np.sqrt(max((x + y + z) * (x + y - z) * (x - y + z) * (-x + y + z), 0.0))


@kernel
def shape_measures(points, tets):
    """Return (m, 5): volume, aspect ratio, smallest and largest dihedral in degrees, shape factor.

    Aspect ratio: longest edge over smallest altitude; infinite for a flat element. Shape factor:
    volume over that of the regular tetrahedron with the same circumsphere; 0 when flat.
    """
    out = np.empty((len(tets), 5))
    face = np.empty((4, 3))
    area = np.empty(4)
    edge = np.empty(6)
    for t in range(len(tets)):
        a, b, c, d = tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3]
        area[0] = _face_vector(points, a, c, b, face[0])
        area[1] = _face_vector(points, a, b, d, face[1])
        area[2] = _face_vector(points, b, c, d, face[2])
        area[3] = _face_vector(points, c, a, d, face[3])
        edge[0], edge[1], edge[2] = _length(points, a, b), _length(points, b, c), _length(points, c, a)
        edge[3], edge[4], edge[5] = _length(points, a, d), _length(points, b, d), _length(points, c, d)
        six_volume = 0.0
        for axis in range(3):
            six_volume -= face[0, axis] * (points[d, axis] - points[a, axis])
        size = abs(six_volume)
        low, high = _cosines(face, area)
        around = _circumradius_times_volume(edge)
        radius = around / (4 * size) if size > 0 else np.inf
        out[t, 0] = six_volume / 6
        out[t, 1] = edge.max() * area.max() / size if size > 0 else np.inf
        out[t, 2] = np.degrees(np.arccos(high))
        out[t, 3] = np.degrees(np.arccos(low))
        out[t, 4] = size / 6 / (8 * np.sqrt(3.0) / 27 * radius**3) if size > 0 else 0.0
    return out
