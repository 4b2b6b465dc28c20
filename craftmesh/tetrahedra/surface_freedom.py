"""Where points of the surface may move: within box planes, within the crack, not along its front."""

from dataclasses import dataclass

import numpy as np

from craftmesh.cracks.promises import TETRAHEDRA
from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import front_edges, median_front_edge
from craftmesh.surface.measure import area_vectors, edge_lengths, point_normals
from craftmesh.types import CRACK, Surface

# Of the edges of a crack without a front: those shorter than the one that stands for the front's. On random
# cracks it is 0.5 to 1.3 of the least length asked for.
SHORT_EDGES = 0.05
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


def crack_length(surface: Surface) -> float:
    """Return the median length of the front's edges, of a crack without a front that of its short edges."""
    front, crack = median_front_edge(surface), surface.facets[surface.kind == CRACK]
    if front or not len(crack):
        return front
    return float(np.quantile(edge_lengths(surface.points, unique_edges(crack)[0]), SHORT_EDGES))


def freedom(surface: Surface) -> Freedom:
    """Return how the points may move: within box planes, and along the crack.

    Points of a crack go along their facets' mean plane, as far as that is within TETRAHEDRA.facets of each
    facet's own; points of its front stay where they are.
    """
    count = len(surface.points)
    free = np.zeros((count, 3, 3))
    free[:, range(3), range(3)] = 1.0
    held = Classification(surface).held
    free[np.repeat(held[:, :, None], 3, axis=2)] = 0.0
    crack = np.flatnonzero(surface.kind == CRACK)
    reach = np.full(count, np.inf)
    if not len(crack):
        return Freedom(free, reach)
    normal, turn = _crack_normals(surface, crack)
    points = np.unique(surface.facets[crack])
    bent = points[turn[points] > 0]
    reach[bent] = TETRAHEDRA.facets * crack_length(surface) / turn[bent]
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
    normal = point_normals(area, corners, len(surface.points))
    turn = np.zeros(len(surface.points))
    for k in range(3):
        np.maximum.at(turn, corners[:, k], np.linalg.norm(np.cross(unit, normal[corners[:, k]]), axis=1))
    return normal, turn


def _beside(normals: np.ndarray) -> np.ndarray:
    """Return the projection (3, 3) onto what is square to all the normals (k, 3)."""
    _, sizes, ways = np.linalg.svd(normals)
    ways = ways[: len(sizes)][sizes > INDEPENDENT]
    return np.eye(3) - ways.T @ ways
