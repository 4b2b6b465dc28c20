"""What a surface's vertices may do: classes, the planes of the box they lie on, and their neighbours."""

from dataclasses import dataclass

import numpy as np

from craftmesh.surface.patches import PLANES, feature_edges, held_by_box
from craftmesh.types import Surface

ON_INTERFACE, ON_LINE, AT_JUNCTION = 0, 1, 2


@dataclass(frozen=True)
class VertexClasses:
    """Classes of the vertices of a conformal surface with n points.

    rank (n,) uint8: ON_INTERFACE, ON_LINE (triple line, or line on or along the box) or AT_JUNCTION
    (quadruple point, or where lines meet the box). fixed (n, 3) bool: coordinates held by the box's
    planes; three at a corner. edges (e, 2) int64 and is_line (e,) bool: edges where other than two
    facets of one patch meet.
    """

    rank: np.ndarray
    fixed: np.ndarray
    edges: np.ndarray
    is_line: np.ndarray


def vertex_classes(surface: Surface) -> VertexClasses:
    """Classify the vertices of the surface."""
    features = feature_edges(surface)
    lines = np.bincount(features.lines.ravel(), minlength=len(surface.points))
    rank = np.where(lines == 0, ON_INTERFACE, np.where(lines == 2, ON_LINE, AT_JUNCTION)).astype(np.uint8)
    return VertexClasses(rank, held_by_box(surface), features.edges, features.is_feature)


def smoothing_neighbours(classes: VertexClasses) -> tuple[np.ndarray, np.ndarray]:
    """Return compressed rows (start (n + 1,), neighbour (k,)) of the vertices that each vertex is drawn to.

    Interface vertices have all their neighbours; vertices on lines and at junctions those along
    lines. On an edge of the box a vertex follows the edge, but where a grain boundary reaches the edge
    it follows the boundary's lines, so that the boundary may slide along.
    """
    tail, head = np.concatenate([classes.edges, classes.edges[:, ::-1]]).T
    is_line = np.tile(classes.is_line, 2)
    on_box_edge = classes.fixed.sum(axis=1) >= 2
    along_box_edge = is_line & ((classes.fixed[tail] & classes.fixed[head]).sum(axis=1) >= 2)
    meets_boundary = on_box_edge & (classes.rank == AT_JUNCTION)
    drawn = is_line | (classes.rank[tail] == ON_INTERFACE)
    drawn &= ~(along_box_edge & meets_boundary[tail])
    tail, head = tail[drawn], head[drawn]
    order = np.lexsort((head, tail))
    start = np.searchsorted(tail[order], np.arange(len(classes.rank) + 1))
    return start, head[order]


def facets_beyond_box(
    moved: np.ndarray, points: np.ndarray, facets: np.ndarray, kind: np.ndarray
) -> np.ndarray:
    """Return (m,) bool: facets (m, 3) of kind (m,) with a vertex past a plane of the box (one with facets).

    points (n, 3): the vertices before, `moved` (n, 3) the same ones now.
    """
    beyond = np.zeros(len(points), bool)
    for plane, axis, upper in PLANES:
        on_plane = facets[kind == plane]
        if len(on_plane):
            level = points[on_plane[0, 0], axis]
            beyond |= moved[:, axis] > level if upper else moved[:, axis] < level
    return beyond[facets].any(axis=1)


def vertices_around(facets: np.ndarray, chosen: np.ndarray, rings: int, n_points: int) -> np.ndarray:
    """Return (n_points,) bool: vertices of the chosen facets and of `rings` rings of facets around them."""
    around = np.zeros(n_points, bool)
    around[facets[chosen].ravel()] = True
    for _ in range(rings):
        around[facets[around[facets].any(axis=1)].ravel()] = True
    return around
