"""Connectivity of triangle soups, computed by free functions and passed, never stored."""

import numpy as np
import scipy
from scipy.sparse import coo_array

from craftmesh.surface.kernels.boundaries import lowest_equal_rows, unbalanced_edges
from craftmesh.surface.kernels.corner_lists import corner_lists


def facet_edges(facets: np.ndarray) -> np.ndarray:
    """Return the directed edges (3m, 2) of `facets` (m, 3): row 3 * f + i goes from corner i to i + 1."""
    return np.asarray(facets, np.int64)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def touching(cells: np.ndarray, marked: np.ndarray) -> np.ndarray:
    """Return (m,) bool: the cells (m, k) with a corner that is marked (n,)."""
    result = marked[cells[:, 0]]
    for corners in cells.T[1:]:
        result |= marked[corners]
    return result


def open_edges(facets: np.ndarray, sides: np.ndarray, count: int) -> np.ndarray:
    """Return rows (k, 3), sorted: label, lower and higher of `count` points where its boundary is open.

    sides (m, 2): labels behind and ahead of facets (m, 3); those with one label on both sides bound none,
    and 0 has no boundary. A boundary is closed where as many facets have an edge one way as the other.
    """
    facets, sides = np.require(facets, np.int64, ["C", "W"]), np.require(sides, np.int32, ["C", "W"])
    found = unbalanced_edges(facets, sides, *corner_lists(facets, count))
    return found[np.lexsort(found.T[::-1])]


def rows_among(triangles: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the row of facets (m, 3) that has the corners of each triangle (k, 3), -1 for none."""
    row_of = {tuple(corners): row for row, corners in enumerate(np.sort(facets, axis=1).tolist())}
    return np.array([row_of.get(tuple(c), -1) for c in np.sort(triangles, axis=1).tolist()], np.int64)


def unique_edges(facets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return undirected edges (e, 2), for each corner its edge (m, 3), and facets per edge (e,).

    Edges come sorted by their lower, then higher point; column i of the second array is the edge
    from corner i to corner i + 1.
    """
    directed = facet_edges(facets)
    if not len(directed):
        return np.zeros((0, 2), np.int64), np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    low, high = directed.min(1), directed.max(1)
    stride = high.max() + 1
    keys, inverse, count = np.unique(low * stride + high, return_inverse=True, return_counts=True)
    edges = np.stack([keys // stride, keys % stride], axis=1)
    return edges, inverse.reshape(-1, 3), count


def edge_sides(of_corner: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return, for each of the chosen edges (e,) bool, rows of `facet_edges` that are it: the first two.

    of_corner (m, 3) is from `unique_edges`; each chosen edge has two facets or more. Row // 3 is the facet.
    """
    order = np.argsort(of_corner.ravel(), kind="stable")
    count = np.bincount(of_corner.ravel(), minlength=len(chosen))
    start = (np.cumsum(count) - count)[chosen]
    return order[start], order[start + 1]


def same_turn(triangles: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return where rows of `triangles` list the same corners in the same sense as rows of `reference`."""
    shift = (triangles == reference[:, :1]).argmax(axis=1)
    return np.take_along_axis(triangles, ((shift + 1) % 3)[:, None], axis=1)[:, 0] == reference[:, 1]


def pieces(facets: np.ndarray) -> np.ndarray:
    """Return the number (m,) of the piece that each facet (m, 3) belongs to, joined across edges.

    Pieces are numbered from 0 in the order of their first facets.
    """
    edges, of_corner, _ = unique_edges(facets)
    count = len(facets)
    ends = np.repeat(np.arange(count), 3), count + of_corner.ravel()
    return joined(count + len(edges), *ends)[:count]


def joined(count: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the piece (count,) of each of `count` things, of which one (k,) and other (k,) hang together.

    Pieces are numbered from 0 in the order of their first things.
    """
    graph = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(count, count))
    return in_order(scipy.sparse.csgraph.connected_components(graph, directed=False)[1])


def in_order(numbers: np.ndarray) -> np.ndarray:
    """Return the numbers (k,) of things from 0 on in the order in which they occur first."""
    _, first, place = np.unique(numbers, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[place.ravel()]


def compact(points: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Drop the points (n, 3) that no cell (m, k) uses.

    Return the used points (u, 3), the cells with their ids, and the old ids (u,) of these points, in order.
    """
    used = np.zeros(len(points), bool)
    used[np.asarray(cells).ravel()] = True
    kept = np.flatnonzero(used)
    new = np.full(len(points), -1, np.int64)
    new[kept] = np.arange(len(kept))
    return points[kept], new[cells], kept


def lowest_equal_point(points: np.ndarray) -> np.ndarray:
    """Return for each point (n, 3) the lowest id among the points with the same coordinates."""
    return lowest_equal_rows((np.ascontiguousarray(points, float) + 0.0).view(np.uint64))  # no -0.0
