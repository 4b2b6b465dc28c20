"""Where points of the surface may move: within box planes, within a flat crack, not along its front."""

import numpy as np

from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.patches import held_by_box
from craftmesh.types import CRACK, Surface

# Sine of half a degree: crack facets at a point that turn by less are one plane. A move of a fifth of an
# edge leaves such facets by 0.002 of it.
FLAT = np.sin(np.radians(0.5))
# Singular values of the normals that hold a point, over which they count as another direction.
INDEPENDENT = 1e-3


def freedom(surface: Surface) -> np.ndarray:
    """Return (n, 3, 3): what makes of any step one that a point may take, by dropping the rest of it.

    Points of box planes stay in them, points of the crack in its plane where its facets at them lie in one;
    points of its front, and others of a curved crack, stay where they are.
    """
    count = len(surface.points)
    free = np.zeros((count, 3, 3))
    free[:, range(3), range(3)] = 1.0
    held = held_by_box(surface)
    free[np.repeat(held[:, :, None], 3, axis=2)] = 0.0
    crack = np.flatnonzero(surface.kind == CRACK)
    if not len(crack):
        return free
    normal, is_flat = _crack_normals(surface, crack)
    stays = np.zeros(count, bool)
    stays[front_edges(surface)] = True
    points = np.unique(surface.facets[crack])
    stays[points] |= ~is_flat[points]
    free[points] -= normal[points, :, None] * normal[points, None, :]
    for point in points[held[points].any(axis=1)].tolist():
        free[point] = _beside(np.vstack([np.eye(3)[held[point]], normal[point]]))
        free[point, held[point]] = free[point][:, held[point]] = 0.0  # not by rounding alone
    free[points[stays[points]]] = 0.0
    return free


def _crack_normals(surface: Surface, crack: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean unit normals (n, 3) of crack facets, and whether those at a point lie in one plane."""
    corners = surface.facets[crack]
    area = area_vectors(surface.points, corners)
    # a crack in a grain boundary has its normals turned as the boundary's facets are
    area[(area @ area[np.linalg.norm(area, axis=1).argmax()]) < 0] *= -1
    unit = area / np.maximum(np.linalg.norm(area, axis=1), np.finfo(float).tiny)[:, None]
    normal = np.zeros((len(surface.points), 3))
    for k in range(3):
        np.add.at(normal, corners[:, k], area)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    is_flat = np.ones(len(surface.points), bool)
    for k in range(3):
        off = np.linalg.norm(np.cross(unit, normal[corners[:, k]]), axis=1) > FLAT
        is_flat[corners[off, k]] = False
    return normal, is_flat


def _beside(normals: np.ndarray) -> np.ndarray:
    """Return the projection (3, 3) onto what is square to all the normals (k, 3)."""
    _, sizes, ways = np.linalg.svd(normals)
    ways = ways[: len(sizes)][sizes > INDEPENDENT]
    return np.eye(3) - ways.T @ ways
