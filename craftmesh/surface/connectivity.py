"""Connectivity of triangle sets; results are computed when needed and never stored in a type."""

import numpy as np

from craftmesh.surface.kernels.boundaries import lowest_equal_rows, unbalanced_edges
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.union_find import pieces_of


def facet_edges(facets: np.ndarray) -> np.ndarray:
    """Return the directed edges (3m, 2) of `facets` (m, 3): row 3 * f + i goes from corner i to i + 1."""
    return np.asarray(facets, np.int64)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def touching(cells: np.ndarray, marked: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of the cells (m, k) that have a marked corner; marked: mask (n,) of points."""
    result = marked[cells[:, 0]]
    for corners in cells.T[1:]:
        result |= marked[corners]
    return result


def corners_of(cells: np.ndarray, count: int, chosen: np.ndarray) -> np.ndarray:
    """Return a mask (count,) of the corners of the cells (m, k) in the mask `chosen` (m,)."""
    result = np.zeros(count, bool)
    result[cells[chosen]] = True
    return result


def layers_around(cells: np.ndarray, count: int, chosen: np.ndarray, layers: int) -> np.ndarray:
    """Return a mask (m,) of the chosen cells and of `layers` layers of cells around them.

    count: number of points that the cells (m, k) may have.
    """
    for _ in range(layers):
        chosen = touching(cells, corners_of(cells, count, chosen))
    return chosen


def open_edges(facets: np.ndarray, sides: np.ndarray, count: int) -> np.ndarray:
    """Return sorted rows (k, 3): a label and the lower and higher point of an open edge of its boundary.

    sides (m, 2): labels behind and ahead of facets (m, 3). A facet with the same label on both sides bounds
    nothing, and label 0 has no boundary. An edge is closed if as many facets run along it one way as the
    other. count: number of points.
    """
    facets, sides = np.require(facets, np.int64, ["C", "W"]), np.require(sides, np.int32, ["C", "W"])
    found = unbalanced_edges(facets, sides, *corner_lists(facets, count))
    return found[np.lexsort(found.T[::-1])]


def rows_among(triangles: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the facet (k,), among facets (m, 3), with the same corners as each triangle (k, 3), or -1."""
    row_of = {tuple(corners): row for row, corners in enumerate(np.sort(facets, axis=1).tolist())}
    return np.array([row_of.get(tuple(c), -1) for c in np.sort(triangles, axis=1).tolist()], np.int64)


def unique_edges(facets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return undirected edges (e, 2), the edge (m, 3) at each corner, and facets per edge (e,).

    Edges are sorted by their lower, then higher point. Column i of the second array is the edge from corner
    i to corner i + 1.
    """
    directed = facet_edges(facets)
    if not len(directed):
        return np.zeros((0, 2), np.int64), np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    low, high = np.minimum(*directed.T), np.maximum(*directed.T)
    stride = high.max() + 1
    keys, inverse, count = np.unique(low * stride + high, return_inverse=True, return_counts=True)
    edges = np.stack([keys // stride, keys % stride], axis=1)
    return edges, inverse.reshape(-1, 3), count


def edge_sides(of_corner: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two rows (k,) of `facet_edges` for each of the k chosen edges: those of its first two facets.

    of_corner (m, 3): from `unique_edges`; chosen (e,): mask of edges with two facets or more. Row // 3 is
    the facet.
    """
    order = np.argsort(of_corner.ravel(), kind="stable")
    count = np.bincount(of_corner.ravel(), minlength=len(chosen))
    start = (np.cumsum(count) - count)[chosen]
    return order[start], order[start + 1]


def same_turn(triangles: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of triangles with the same corners in the same orientation as `reference`."""
    shift = (triangles == reference[:, :1]).argmax(axis=1)
    return np.take_along_axis(triangles, ((shift + 1) % 3)[:, None], axis=1)[:, 0] == reference[:, 1]


def pieces(facets: np.ndarray) -> np.ndarray:
    """Return the number (m,) of the edge-connected piece that each facet (m, 3) belongs to.

    Pieces are numbered from 0 in the order of their first facets.
    """
    edges, of_corner, _ = unique_edges(facets)
    count = len(facets)
    ends = np.repeat(np.arange(count), 3), count + of_corner.ravel()
    return joined(count + len(edges), *ends)[:count]


def joined(count: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the connected piece (count,) of each of `count` items; one (k,), other (k,): linked pairs.

    Pieces are numbered from 0 in the order of their first items.
    """
    ends = (np.require(rows, np.int64, ["C", "W"]) for rows in (one, other))
    return pieces_of(count, *ends)


def in_order(numbers: np.ndarray) -> np.ndarray:
    """Return `numbers` (k,) renumbered from 0 in the order in which they first occur."""
    if len(numbers) and numbers.min() == numbers.max():  # as in most meshes
        return np.zeros(len(numbers), np.int64)
    _, first, place = np.unique(numbers, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[place.ravel()]


def compact(points: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Drop the points (n, 3) that no cell (m, k) uses.

    Return the used points (u, 3), the cells with new ids, and the old ids (u,) of the used points,
    ascending.
    """
    used = np.zeros(len(points), bool)
    used[np.asarray(cells).ravel()] = True
    kept = np.flatnonzero(used)
    new = np.full(len(points), -1, np.int64)
    new[kept] = np.arange(len(kept))
    return points[kept], new[cells], kept


def lowest_equal_point(points: np.ndarray) -> np.ndarray:
    """Return the lowest id (n,) among the points with the same coordinates as each point (n, 3)."""
    return lowest_equal_rows((np.ascontiguousarray(points, float) + 0.0).view(np.uint64))  # no -0.0
