"""Shape of single facets, given by point ids: normals, angle scores and distances."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel

# Degrees: a facet has an angle score of 1 if its smallest or its largest angle is this.
LEAST_ANGLE = 15.0
LARGEST_ANGLE = 135.0
_LEAST = 1.0 - np.cos(np.radians(LEAST_ANGLE))
_LARGEST = 1.0 + np.cos(np.radians(LARGEST_ANGLE))


@lean_kernel
def area_vector(points, a, b, c):
    """Return the components of twice the area vector of facet (a, b, c)."""
    ux = points[b, 0] - points[a, 0]
    uy = points[b, 1] - points[a, 1]
    uz = points[b, 2] - points[a, 2]
    vx = points[c, 0] - points[a, 0]
    vy = points[c, 1] - points[a, 1]
    vz = points[c, 2] - points[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@lean_kernel
def squared_distance(points, a, b):
    """Return the squared length of edge (a, b)."""
    x = points[b, 0] - points[a, 0]
    y = points[b, 1] - points[a, 1]
    z = points[b, 2] - points[a, 2]
    return x * x + y * y + z * z


@kernel
def relative_lengths(points, size, edges):
    """Return lengths (e,) of `edges` (e, 2) relative to the mean target length `size` of their two ends."""
    ratio = np.empty(len(edges))
    for n in range(len(edges)):
        a = edges[n, 0]
        b = edges[n, 1]
        ratio[n] = np.sqrt(squared_distance(points, a, b)) / (0.5 * (size[a] + size[b]))
    return ratio


@lean_kernel
def mean_edge(points, facets, alive, count):
    """Return the mean length of the edges 0 (corner 0 to 1) of facets marked `alive` among `count` rows."""
    total, living = 0.0, 0
    for f in range(count):
        if alive[f]:
            total += np.sqrt(squared_distance(points, facets[f, 0], facets[f, 1]))
            living += 1
    return total / max(living, 1)


@lean_kernel
def cosine_range(points, a, b, c):
    """Return the cosines of the smallest and largest angle; 1 and -1 for a degenerate facet."""
    x = squared_distance(points, b, c)
    y = squared_distance(points, a, c)
    z = squared_distance(points, a, b)
    if x > y:
        x, y = y, x
    if y > z:
        y, z = z, y
    if x > y:
        x, y = y, x
    if x <= 0.0:
        return 1.0, -1.0
    smallest = (y + z - x) / (2.0 * np.sqrt(y * z))
    largest = (x + y - z) / (2.0 * np.sqrt(x * y))
    return min(smallest, 1.0), max(largest, -1.0)


def score_of_angle(degrees: float) -> float:
    """Return the angle score of a facet with a smallest angle of `degrees` and no large angle."""
    return float((1.0 - np.cos(np.radians(degrees))) / _LEAST)


@lean_kernel
def angle_score(points, a, b, c):
    """Return the angle score of facet (a, b, c): larger is better, 0 if degenerate.

    It is 1 if the smallest angle is 15 or the largest 135 degrees, and the worse of the two angles decides.
    """
    smallest, largest = cosine_range(points, a, b, c)
    return min((1.0 - smallest) / _LEAST, (1.0 + largest) / _LARGEST)


@kernel
def poor_facets(points, facets, alive, count, score):
    """Return ids of facets marked `alive`, among the first `count`, whose angle score is below `score`."""
    found = np.empty(count, np.int64)
    n = 0
    for f in range(count):
        if alive[f] and angle_score(points, facets[f, 0], facets[f, 1], facets[f, 2]) < score:
            found[n] = f
            n += 1
    return found[:n].copy()


@lean_kernel
def keeps_normal(points, reference, f, a, b, c, cosine):
    """Return whether the normal of (a, b, c) is within an angle of given `cosine` from reference[f]."""
    x, y, z = area_vector(points, a, b, c)
    length = np.sqrt(x * x + y * y + z * z)
    along = x * reference[f, 0] + y * reference[f, 1] + z * reference[f, 2]
    return length > 0.0 and along >= cosine * length


@lean_kernel
def segment_distance2(points, a, b, places, row):
    """Return the squared distance of point places[row] from the segment (a, b)."""
    dx = points[b, 0] - points[a, 0]
    dy = points[b, 1] - points[a, 1]
    dz = points[b, 2] - points[a, 2]
    px = places[row, 0] - points[a, 0]
    py = places[row, 1] - points[a, 1]
    pz = places[row, 2] - points[a, 2]
    length2 = dx * dx + dy * dy + dz * dz
    t = 0.0
    if length2 > 0.0:
        t = min(1.0, max(0.0, (px * dx + py * dy + pz * dz) / length2))
    px -= t * dx
    py -= t * dy
    pz -= t * dz
    return px * px + py * py + pz * pz


@lean_kernel
def facet_distance2(points, a, b, c, places, row, bound):
    """Return the squared distance of places[row] from facet (a, b, c), or `bound` if that is smaller.

    bound: a squared distance, too.
    """
    nx, ny, nz = area_vector(points, a, b, c)
    n2 = nx * nx + ny * ny + nz * nz
    wx = places[row, 0] - points[a, 0]
    wy = places[row, 1] - points[a, 1]
    wz = places[row, 2] - points[a, 2]
    h = 0.0
    if n2 > 0.0:
        h = wx * nx + wy * ny + wz * nz
        if h * h >= bound * n2:
            return bound
    nearest = bound
    inside = n2 > 0.0
    for i in range(3):
        u = a if i == 0 else (b if i == 1 else c)
        v = b if i == 0 else (c if i == 1 else a)
        ex = points[v, 0] - points[u, 0]
        ey = points[v, 1] - points[u, 1]
        ez = points[v, 2] - points[u, 2]
        wx = places[row, 0] - points[u, 0]
        wy = places[row, 1] - points[u, 1]
        wz = places[row, 2] - points[u, 2]
        side = (ey * wz - ez * wy) * nx + (ez * wx - ex * wz) * ny + (ex * wy - ey * wx) * nz
        # the nearest boundary point is on an edge on whose outer side the place lies
        if side < 0.0 or n2 <= 0.0:
            inside = False
            nearest = min(nearest, segment_distance2(points, u, v, places, row))
    return h * h / n2 if inside else nearest
