"""Bounds of moves of surface points, by their classification (patch, line, box plane, crack, front).

Points move along the surface, and off the surface at faulty tetrahedra. In both cases points on box planes
stay on them and front points stay. Crack points stay in moves along the surface; in moves off the surface
they move nearly within the crack.
"""

import numpy as np

from craftmesh.cracks.crack_tolerances import TETRAHEDRA
from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import lowest_equal_point, unique_edges
from craftmesh.surface.front import median_front_edge
from craftmesh.surface.kernels.ranks import IN_PATCH, ON_LINE
from craftmesh.surface.measure import area_vectors, edge_lengths, mean_edges
from craftmesh.tetrahedra.tet_state import Bounds
from craftmesh.types import CRACK, Surface

# Largest move along the surface, relative to the mean length of the edges at the point.
SLIDE = 0.3
# Degrees: largest deviation of a point's facets, or of its line's edges, from their mean direction for a
# move along the surface. If all points moved, the volumes of small grains would change by several percent.
BEND = 15.0
# Quantile of the crack's edge lengths that stands for the length of front edges if a crack has no front. On
# random cracks it is 0.5 to 1.3 times l_min.
SHORT_EDGES = 0.05


def crack_length(surface: Surface) -> float:
    """Return the median length of front edges, or without a front the SHORT_EDGES quantile of crack edges.

    The result is 0 without a crack.
    """
    front, crack = median_front_edge(surface), surface.facets[surface.kind == CRACK]
    if front or not len(crack):
        return front
    return float(np.quantile(edge_lengths(surface.points, unique_edges(crack)[0]), SHORT_EDGES))


def along_surface(surface: Surface) -> Bounds:
    """Return bounds for moves along the surface, on flat patches and straight lines.

    Junction points, crack points, coincident points and points where patch or line bends by more than BEND
    stay. A point on a box plane moves exactly within the plane. The reach is SLIDE mean edges.
    """
    classes, points = Classification(surface), surface.points
    lowest = lowest_equal_point(points)
    may = ~classes.on_crack & (np.bincount(lowest, minlength=len(lowest))[lowest] == 1)
    lines, corners = classes.features.lines, surface.facets
    ways = np.zeros((len(points), 3, 3))
    for rank, held_by, vectors, free in (
        (IN_PATCH, corners, area_vectors(points, corners), (0, 1)),
        (ON_LINE, lines, points[lines[:, 1]] - points[lines[:, 0]], (2,)),
    ):
        nodes = np.flatnonzero(may & (classes.rank == rank))
        parts, axes = np.linalg.eigh(_products(vectors, held_by, len(points))[nodes])
        straight = parts[:, 2] > np.cos(np.radians(BEND)) ** 2 * parts.sum(axis=1)
        for way in free:
            ways[nodes[straight], way] = axes[straight][:, :, way]
    ways[np.repeat(classes.held[:, None], 3, axis=1)] = 0.0
    return Bounds(points, ways, SLIDE * mean_edges(points, classes.features.edges))


def off_surface(surface: Surface) -> Bounds:
    """Return bounds for moves off the surface, within box planes and along the crack.

    A crack point moves in the mean plane of its crack facets, as far as this plane is within
    TETRAHEDRA.facets times `crack_length` of each facet's plane. Front points stay. For points off the
    crack the reach is infinite here; the caller bounds it.
    """
    classes, points = Classification(surface), surface.points
    ways, reach = np.repeat(np.eye(3)[None], len(points), axis=0), np.full(len(points), np.inf)
    crack = surface.facets[surface.kind == CRACK]
    if len(crack):
        vectors, nodes = area_vectors(points, crack), np.flatnonzero(classes.on_crack)
        normal = np.linalg.eigh(_products(vectors, crack, len(points))[nodes])[1][:, :, 2]
        number = np.searchsorted(nodes, crack)
        off = np.linalg.norm(np.cross(vectors[:, None], normal[number]), axis=2)
        off /= np.maximum(np.linalg.norm(vectors, axis=1), np.finfo(float).tiny)[:, None]
        turn = np.zeros(len(nodes))
        np.maximum.at(turn, number, off)
        with np.errstate(divide="ignore"):
            reach[nodes] = TETRAHEDRA.facets * crack_length(surface) / turn
        held = classes.held[nodes]
        kept = normal[:, :, None] * normal[:, None, :] + held[:, :, None] * np.eye(3)
        count, axes = held.sum(axis=1), np.swapaxes(np.linalg.eigh(kept)[1], 1, 2)
        ways[nodes] = axes * (np.arange(3) < 2 - count[:, None])[:, :, None]
    ways[np.repeat(classes.held[:, None], 3, axis=1)] = 0.0
    ways[classes.on_front] = 0.0
    return Bounds(points, ways, reach)


def _products(vectors: np.ndarray, corners: np.ndarray, count: int) -> np.ndarray:
    """Return for each point the matrix (count, 3, 3) that sums v v^T / |v| over the vectors v at the point.

    vectors (m, 3): of facets or edges; corners (m, k): ids of the points of each facet or edge. The
    eigenvector of the largest eigenvalue is the mean direction.
    """
    size = np.maximum(np.linalg.norm(vectors, axis=1), np.finfo(float).tiny)
    products = (vectors[:, :, None] * vectors[:, None, :] / size[:, None, None]).reshape(-1, 9)
    columns = [sum(np.bincount(c, p, count) for c in corners.T) for p in products.T]
    return np.stack(columns, axis=1).reshape(-1, 3, 3)
