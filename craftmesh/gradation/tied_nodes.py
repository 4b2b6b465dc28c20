"""Release of tied nodes (paper, section 2.2, Fig. 2): vertices in which sheets meet in a single point."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.surface.connectivity import joined
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.patches import FeatureEdges, box_axis, feature_edges
from craftmesh.types import CRACK, Surface


def release_tied_nodes(surface: Surface) -> tuple[Surface, int, int]:
    """Give each fan of a tied node a copy of its own; return how many nodes were released and refused.

    A fan: facets at the node that are connected over shared edges. Each copy goes to the centroid of
    the polygon of its fan's outer vertices, within the box plane that the fan lies on. Nodes on
    junction lines or on the crack stay as they are; so do those, counted as refused, whose release
    would make facets intersect or pass over another vertex. Facets keep their order.
    """
    facets = surface.facets.astype(np.int64)
    corners, copies, node = fans = _fans(surface, facets)
    tied = np.unique(node)
    if not len(tied):
        return surface, 0, 0
    centroid = _centroids(surface, facets, corners, copies, len(node))
    ours = np.arange(len(facets))[_near(surface.points, facets, tied)]
    known = {tuple(pair) for pair in intersecting_pairs(surface.points, facets[ours])}
    passing = node[np.unique(copies[_passes_points(surface.points, facets, corners, centroid[copies])])]
    released = ~np.isin(tied, passing)
    while True:
        points, connected = _split(surface, fans, centroid, released[np.searchsorted(tied, node)])
        pairs = [p for p in intersecting_pairs(points, connected[ours]) if tuple(p) not in known]
        hit = ours[np.array(pairs, np.int64).reshape(-1)]
        back = np.isin(tied, facets[hit]) & released
        if not back.any():
            break
        released &= ~back
    result = Surface(points, connected, surface.sides, surface.kind) if released.any() else surface
    return result, int(released.sum()), int((~released).sum())


def _fans(surface: Surface, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the corners of tied nodes, the fan of each, and the node of each fan.

    Corner c is facets[c // 3, c % 3]; fans are numbered in the order of their nodes.
    """
    features = feature_edges(surface)
    bound = np.zeros(len(surface.points), bool)
    bound[features.lines] = True
    bound[facets[surface.kind == CRACK]] = True
    corner = np.flatnonzero(~bound[facets].ravel())
    vertex = facets.ravel()[corner]
    fan = _connected(features, corner, vertex)
    fans_of = np.zeros(len(surface.points), np.int64)
    first = np.unique(fan, return_index=True)[1]
    np.add.at(fans_of, vertex[first], 1)
    tied = fans_of[vertex] > 1
    key = vertex[tied] * (len(first) + 1) + fan[tied]
    keys, copies = np.unique(key, return_inverse=True)
    return corner[tied], copies.reshape(-1), keys // (len(first) + 1)


def _connected(features: FeatureEdges, corner: np.ndarray, vertex: np.ndarray) -> np.ndarray:
    """Return per corner the number of its fan: corners at one vertex joined over the edges there."""
    edges, edge_of = features.edges, features.of_corner
    row, column = corner // 3, corner % 3
    joints = []
    for edge in (edge_of[row, column], edge_of[row, (column + 2) % 3]):
        joints.append(len(corner) + 2 * edge + (edges[edge, 1] == vertex))
    link = np.tile(np.arange(len(corner)), 2), np.concatenate(joints)
    size = len(corner) + 2 * len(edges)
    return joined(size, *link)[: len(corner)]


def _centroids(
    surface: Surface, facets: np.ndarray, corners: np.ndarray, copies: np.ndarray, count: int
) -> np.ndarray:
    """Return the centroid (count, 3) of each fan's polygon; fans on a box plane stay on it exactly."""
    row, column = corners // 3, corners % 3
    following = surface.points[facets[row, (column + 1) % 3]]
    preceding = surface.points[facets[row, (column + 2) % 3]]
    size = 2.0 * np.bincount(copies, minlength=count)
    total = np.zeros((count, 3))
    np.add.at(total, copies, following + preceding)
    centroid = total / size[:, None]
    normal_to = box_axis(surface.kind[row])
    for axis in range(3):
        on_plane = normal_to == axis
        centroid[copies[on_plane], axis] = surface.points[facets.ravel()[corners[on_plane]], axis]
    return centroid


def _passes_points(
    points: np.ndarray, facets: np.ndarray, corners: np.ndarray, target: np.ndarray
) -> np.ndarray:
    """Return (k,) bool: corners whose facet passes over a vertex when the corner moves to `target`."""
    row, column = corners // 3, corners % 3
    start, a, b = (points[facets[row, (column + i) % 3]] for i in range(3))
    reach = np.linalg.norm(np.stack([a, b]) - start, axis=2).max(axis=0)
    around = cKDTree(points).query_ball_point(start, reach)
    which = np.repeat(np.arange(len(corners)), [len(ids) for ids in around])
    inside = points[np.concatenate(around).astype(np.int64)]
    total = _spanned(start, a, b, target)[which]
    whole = np.abs(total) > 0
    for part in (
        _spanned(inside, a[which], b[which], target[which]),
        _spanned(start[which], inside, b[which], target[which]),
        _spanned(start[which], a[which], inside, target[which]),
        _spanned(start[which], a[which], b[which], inside),
    ):
        whole &= part * np.sign(total) > 1e-9 * np.abs(total)
    return np.bincount(which, whole, minlength=len(corners)) > 0


def _spanned(o: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return six times the signed volumes (k,) of tetrahedra o, a, b, c."""
    return np.einsum("ij,ij->i", np.cross(a - o, b - o), c - o)


def _near(points: np.ndarray, facets: np.ndarray, tied: np.ndarray) -> np.ndarray:
    """Return (m,) bool: the facets that may come to meet the facets at the tied nodes."""
    centre = points[facets].mean(axis=1)
    radius = np.linalg.norm(points[facets] - centre[:, None], axis=2).max(axis=1)
    star = np.isin(facets, tied).any(axis=1)
    reach = 2 * radius[star].max()
    distance, _ = cKDTree(points[tied]).query(centre, distance_upper_bound=reach + radius.max() + 1e-300)
    return distance <= reach + radius


def _split(
    surface: Surface,
    fans: tuple[np.ndarray, np.ndarray, np.ndarray],
    centroid: np.ndarray,
    goes: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return points and facets where `fans` that go (k,) have copies of their nodes at their centroids."""
    corners, copies, node = fans
    points, facets = surface.points, surface.facets.astype(np.int64)
    first = np.concatenate([[True], node[1:] != node[:-1]])
    fresh = goes & ~first
    place = node.copy()
    place[fresh] = len(points) + np.arange(fresh.sum())
    moved = np.concatenate([points, np.zeros((int(fresh.sum()), 3))])
    moved[place[goes]] = centroid[goes]
    connected = facets.ravel().copy()
    connected[corners] = place[copies]
    return moved, connected.reshape(facets.shape)
