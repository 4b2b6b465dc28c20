"""The plane over which a crack is a height: from its triangles' normals."""

import numpy as np

from craftmesh.cracks.prescription import frame_along
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.rounding import ROUNDING

# Slopes of up to 45 degrees stretch lengths in the plane by 1.4 at most; a direction in which all triangles
# have a say, by their area, is then better than one that the steepest decide.
STEEP = np.cos(np.radians(45.0))


def best_fit_frame(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return rows u, v, normal (3, 3) of the plane over which the triangles (m, 3) are a height.

    points (n, 3). The normal is the mean of the triangles', by area, or where that leaves one steeper than
    45 degrees the direction to which the steepest is least steep. All triangles have to be turned alike;
    where they are a height over no plane, it is the mean. u is where the crack is longest.
    """
    vectors = area_vectors(points, triangles)
    weight = np.linalg.norm(vectors, axis=1)
    proper = weight > ROUNDING * weight.sum() / len(weight)
    normals = vectors[proper] / weight[proper, None]
    mean = vectors.sum(axis=0)
    normal = mean / np.linalg.norm(mean) if np.linalg.norm(mean) > ROUNDING * weight.sum() else normals[0]
    if (normals @ normal).min() < STEEP:
        direction = least_steep(normals)
        normal = direction if (normals @ direction).min() > 0 else normal
    corners = points[triangles].reshape(-1, 3)
    corner_weight = np.repeat(weight, 3)
    centred = corners - np.average(corners, axis=0, weights=corner_weight)
    across = centred - (centred @ normal)[:, None] * normal
    _, axes = np.linalg.eigh((across * corner_weight[:, None]).T @ across)
    return frame_along(normal, axes[:, 2])


def least_steep(normals: np.ndarray) -> np.ndarray:
    """Return the unit vector d (3,) that makes the least cosine n_i . d of unit normals (m, 3) largest.

    It points to the point of the normals' convex hull that is nearest to the origin: least squares in
    weights >= 0 (Lawson & Hanson 1974, chapter 23) over the few normals that decide it. Where the hull
    holds the origin, no direction has only positive cosines.
    """
    from scipy.optimize import nnls  # a tenth of a second, and steep cracks alone need it

    direction = normals[0]
    chosen = [int(np.argmin(normals @ normals.mean(axis=0)))]
    for _ in normals:  # each round adds the steepest
        weights, _ = nnls(np.vstack([normals[chosen].T, np.ones(len(chosen))]), np.array([0, 0, 0, 1.0]))
        nearest = weights @ normals[chosen]
        if np.linalg.norm(nearest) <= ROUNDING:
            break
        direction = nearest / np.linalg.norm(nearest)
        cosine = normals @ direction
        steepest = int(np.argmin(cosine))
        if cosine[steepest] >= cosine[chosen].min() - ROUNDING:
            break
        chosen.append(steepest)
    return direction
