"""Where points of the surface may move: within box planes, within the crack, not along its front."""

from dataclasses import dataclass

import numpy as np

from craftmesh.surface.front import front_edges, median_front_edge
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.patches import held_by_box
from craftmesh.types import CRACK, Surface

# Of the median front edge: how far the crack may go from where it was. Of the 0.05 that are allowed the
# gradation leaves 0.005: with 0.01 a kinked crack ended 0.0515 off. Wider reaches gain nothing: of five
# random cracks with 98 to 246 tets over an aspect ratio of 5 none had over a twentieth fewer with 0.05.
CRACK_REACH = 0.005
# Singular values of the normals that hold a point, over which they count as another direction.
INDEPENDENT = 1e-3


@dataclass(frozen=True)
class Freedom:
    """How points of the surface may move.

    steps (n, 3, 3): what makes of any step one that the point may take, by dropping the rest of it; reach
    (n,): how far it may go for the crack's sake, infinite off the crack and where the crack is flat.
    """

    steps: np.ndarray
    reach: np.ndarray


def freedom(surface: Surface) -> Freedom:
    """Return how the points may move: within box planes, and along the crack.

    Points of a crack go along their facets' mean plane, as far as that is within CRACK_REACH of each
    facet's own; points of its front stay where they are.
    """
    count = len(surface.points)
    free = np.zeros((count, 3, 3))
    free[:, range(3), range(3)] = 1.0
    held = held_by_box(surface)
    free[np.repeat(held[:, :, None], 3, axis=2)] = 0.0
    crack = np.flatnonzero(surface.kind == CRACK)
    reach = np.full(count, np.inf)
    if not len(crack):
        return Freedom(free, reach)
    normal, turn = _crack_normals(surface, crack)
    points = np.unique(surface.facets[crack])
    bent = points[turn[points] > 0]
    reach[bent] = CRACK_REACH * median_front_edge(surface) / turn[bent]
    free[points] -= normal[points, :, None] * normal[points, None, :]
    for point in points[held[points].any(axis=1)].tolist():
        free[point] = _beside(np.vstack([np.eye(3)[held[point]], normal[point]]))
        free[point, held[point]] = free[point][:, held[point]] = 0.0  # not by rounding alone
    free[front_edges(surface)] = 0.0
    return Freedom(free, reach)


def _crack_normals(surface: Surface, crack: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean unit normals (n, 3) of crack facets, and the largest sine (n,) that one is off them."""
    corners = surface.facets[crack]
    area = area_vectors(surface.points, corners)
    # a crack in a grain boundary has its normals turned as the boundary's facets are
    area[(area @ area[np.linalg.norm(area, axis=1).argmax()]) < 0] *= -1
    unit = area / np.maximum(np.linalg.norm(area, axis=1), np.finfo(float).tiny)[:, None]
    normal = np.zeros((len(surface.points), 3))
    for k in range(3):
        np.add.at(normal, corners[:, k], area)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    turn = np.zeros(len(surface.points))
    for k in range(3):
        np.maximum.at(turn, corners[:, k], np.linalg.norm(np.cross(unit, normal[corners[:, k]]), axis=1))
    return normal, turn


def _beside(normals: np.ndarray) -> np.ndarray:
    """Return the projection (3, 3) onto what is square to all the normals (k, 3)."""
    _, sizes, ways = np.linalg.svd(normals)
    ways = ways[: len(sizes)][sizes > INDEPENDENT]
    return np.eye(3) - ways.T @ ways
