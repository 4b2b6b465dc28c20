"""Release of tied nodes (paper, section 2.2, Fig. 2): vertices in which parts of the surface only touch.

A fan is a set of facets at a node that are connected over shared edges; a tied node has several fans.
"""

import numpy as np
import scipy

from craftmesh.surface.connectivity import compact, joined
from craftmesh.surface.guarded_move import RELEASING, guarded_move
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.patches import FeatureEdges, box_axis, feature_edges
from craftmesh.types import CRACK, Surface


def release_tied_nodes(surface: Surface) -> tuple[Surface, int, int]:
    """Return the surface with a copy of each tied node per fan, and the numbers of nodes released and kept.

    Each copy moves to the centroid of its fan's outer vertices, within the fan's box plane if it has one.
    Nodes on junction lines or on the crack are not touched and not counted. A tied node is kept if its
    release would make facets intersect or pass over another vertex. Facets keep their order.
    """
    facets = surface.facets.astype(np.int64)
    corners, copies, node = _fans(surface, facets)
    tied = np.unique(node)
    if not len(tied):
        return surface, 0, 0
    centroid = _centroids(surface, facets, corners, copies, len(node))
    passing = np.isin(node, node[copies[_passes_points(surface.points, facets, corners, centroid[copies])]])
    fresh = np.diff(node, prepend=-1) == 0
    ids = np.where(fresh, len(surface.points) + np.cumsum(fresh) - 1, node)
    doubled = np.concatenate([surface.points, surface.points[node[fresh]]])
    parted = _parted(surface, doubled, corners, ids[copies])
    targets = parted.points.copy()
    targets[ids[~passing]] = centroid[~passing]
    known = intersecting_pairs(surface.points, facets)
    points, held = guarded_move(parted, targets, RELEASING, known=known)
    # fans whose copy must not move share the lowest of their copies, so that they are joined again
    stays = passing | held[ids]
    first = np.full(len(points), len(points))
    np.minimum.at(first, node[stays], ids[stays])
    refused = np.bincount(node[stays], minlength=len(points))[tied] > 1
    if refused.all():
        return surface, 0, len(tied)
    ids = np.where(stays, first[node], ids)
    points, facets, _ = compact(points, _parted(surface, points, corners, ids[copies]).facets)
    result = Surface(points, facets, surface.sides, surface.kind)
    return result, int((~refused).sum()), int(refused.sum())


def _parted(surface: Surface, points: np.ndarray, corners: np.ndarray, ids: np.ndarray) -> Surface:
    """Return the surface on `points`, with point ids[i] at corner corners[i] of the flattened facets."""
    facets = surface.facets.astype(np.int64).ravel()
    facets[corners] = ids
    return Surface(points, facets.reshape(-1, 3), surface.sides, surface.kind)


def _fans(surface: Surface, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return corners (k,) at tied nodes, the fan number (k,) of each, and the node id (n,) of each fan.

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
    """Return the fan number of each corner (k,): corners at one vertex that share edges are one fan."""
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
    """Return the centroid (count, 3) of each fan's outer vertices; a fan in a box plane keeps it exactly.

    corners, copies (k,): corners at tied nodes and the fan number of each; count: number of fans.
    """
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
    """Return a mask (k,) of corners whose facet sweeps over a vertex if they move to target (k, 3)."""

    row, column = corners // 3, corners % 3
    start, a, b = (points[facets[row, (column + i) % 3]] for i in range(3))
    reach = np.linalg.norm(np.stack([a, b]) - start, axis=2).max(axis=0)
    around = scipy.spatial.cKDTree(points).query_ball_point(start, reach)
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
    """Return six times the signed volumes (k,) of the tetrahedra o, a, b, c, each (k, 3)."""
    return np.einsum("ij,ij->i", np.cross(a - o, b - o), c - o)
