"""The crack opened: nodes come apart where nothing but crack facets holds the tets round them together."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from craftmesh.mesh.tet_connectivity import FACE_CORNERS, half_face_corners


def opened_tets(
    tets: np.ndarray, linked: np.ndarray, bounding: np.ndarray, n_points: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the tets on separated nodes and the old node (n,) of each new one; old ids come first.

    linked (p, 2): half faces that stay together; bounding: half faces that are free or on the crack.
    Only nodes of the latter can come apart: around any other the elements fill the whole sphere.
    """
    at_boundary = np.zeros(n_points, bool)
    at_boundary[half_face_corners(tets, bounding)] = True
    linked = linked[at_boundary[half_face_corners(tets, linked[:, 0])].any(axis=1)]
    here, there = (half_face_corners(tets, linked[:, i]) for i in range(2))
    links = []
    for i in range(3):
        same = (there == here[:, i, None]).argmax(axis=1)
        ends = [4 * (rows // 4) + FACE_CORNERS[rows % 4, j] for rows, j in zip(linked.T, (i, same))]
        links.append(np.stack(ends, axis=1)[at_boundary[here[:, i]]])
    movable = np.flatnonzero(at_boundary[tets.ravel()])  # flat (tet, corner) ids
    return _renumber(tets, movable, np.concatenate(links), n_points)


def _renumber(
    tets: np.ndarray, movable: np.ndarray, links: np.ndarray, n_points: int
) -> tuple[np.ndarray, np.ndarray]:
    """Give each component of the movable corners a node; the first of each old node keeps its id."""
    place = np.full(tets.size, -1, np.int64)
    place[movable] = np.arange(len(movable))
    ones = np.ones(len(links), np.int8)
    graph = coo_array((ones, (place[links[:, 0]], place[links[:, 1]])), shape=(len(movable),) * 2)
    count, component = connected_components(graph, directed=False)
    first = np.full(count, len(movable), np.int64)
    np.minimum.at(first, component, np.arange(len(movable)))
    old = tets.ravel()[movable[first]]
    order = np.lexsort((first, old))
    repeated = np.zeros(count, bool)
    repeated[order[1:]] = old[order[1:]] == old[order[:-1]]
    extra = order[repeated[order]]
    new_id = old.copy()
    new_id[extra] = n_points + np.arange(len(extra))
    opened = tets.copy()
    opened.ravel()[movable] = new_id[component]
    return opened, np.concatenate([np.arange(n_points), old[extra]])


def drop_unused(
    points: np.ndarray, tets: np.ndarray, parent: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (n, 3), tets and parents (n,) without the points that no tet uses."""
    used = np.zeros(len(points), bool)
    used[tets.ravel()] = True
    new = np.cumsum(used) - 1
    return points[used], new[tets], parent[used]


def is_closed(opened: np.ndarray, crack_pairs: np.ndarray) -> np.ndarray:
    """Return which crack facets (p,) kept all three corners on both sides: they cannot open."""
    corners = np.sort(half_face_corners(opened, crack_pairs), axis=2)
    return (corners[:, 0] == corners[:, 1]).all(axis=1)
