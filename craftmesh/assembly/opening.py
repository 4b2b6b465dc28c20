"""Opening of the crack: nodes are separated where only crack facets connect the tetrahedra around them."""

from collections.abc import Mapping

import numpy as np

from craftmesh.mesh.mesh_sets import is_front, is_lip
from craftmesh.mesh.tet_connectivity import FACE_NODES, half_face_corners, half_face_nodes, told_apart
from craftmesh.surface.connectivity import joined


def opened_tets(
    tets: np.ndarray, linked: np.ndarray, bounding: np.ndarray, n_points: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the tets on separated nodes, and the old node (n,) of each node; old nodes come first.

    tets (m, 4) or (m, 10). linked (p, 2): pairs of half faces (4 * tet + face) that stay together;
    bounding: half faces that are free or on the crack. Only nodes of `bounding` can be separated, because
    around any other node the elements fill the whole sphere. n_points: number of old nodes.
    """
    width = tets.shape[1]
    local = FACE_NODES[width]
    at_boundary = np.zeros(n_points, bool)
    at_boundary[half_face_nodes(tets, bounding)] = True
    linked = linked[at_boundary[half_face_nodes(tets, linked[:, 0])].any(axis=1)]
    here, there = (half_face_nodes(tets, linked[:, i]) for i in range(2))
    links = []
    for i in range(local.shape[1]):
        same = (there == here[:, i, None]).argmax(axis=1)
        ends = [width * (rows // 4) + local[rows % 4, j] for rows, j in zip(linked.T, (i, same))]
        links.append(np.stack(ends, axis=1)[at_boundary[here[:, i]]])
    movable = np.flatnonzero(at_boundary[tets.ravel()])  # flat (tet, node) ids
    place = np.full(tets.size, -1, np.int64)
    place[movable] = np.arange(len(movable))
    component = joined(len(movable), *place[np.concatenate(links)].T)
    opened = tets.copy()
    opened.ravel()[movable], old = told_apart(tets.ravel()[movable], component, n_points)
    return opened, np.concatenate([np.arange(n_points), old])


def opened_across(
    tets: np.ndarray, linked: np.ndarray, across: np.ndarray, n_points: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return tets and old nodes as `opened_tets` does, and a mask (p,) of crack facets that stay closed.

    across (p, 2): the half faces on both sides of each crack facet. A facet stays closed, with its mid
    nodes, if all its corners stay single, as for a facet with all corners on the front.
    """
    by_corners, _ = opened_tets(tets[:, :4], linked, across.ravel(), n_points)
    shut = is_closed(by_corners, across)
    linked = np.concatenate([linked, across[shut]])
    return *opened_tets(tets, linked, across.ravel(), n_points), shut


def with_copies(
    node_sets: Mapping[str, np.ndarray], parent: np.ndarray, count: int
) -> dict[str, np.ndarray]:
    """Return the node sets, with the copies of their nodes at the end, but no sets of lips and fronts.

    parent (n,): the old node of each node; count: number of old nodes, which come first.
    """
    return {
        name: np.concatenate([nodes, copies_of(nodes, parent, count)])
        for name, nodes in node_sets.items()
        if not is_lip(name) and not is_front(name)
    }


def copies_of(nodes: np.ndarray, parent: np.ndarray, count: int) -> np.ndarray:
    """Return the new nodes (k,) that were separated from `nodes`, of the `count` old nodes.

    parent (n,): the old node of each node; old nodes come first.
    """
    copies: np.ndarray = count + np.flatnonzero(np.isin(parent[count:], nodes))
    return copies


def is_closed(opened: np.ndarray, crack_pairs: np.ndarray) -> np.ndarray:
    """Return a mask (p,) of crack facets with the same three corners on both sides, which cannot open.

    crack_pairs (p, 2): the half faces on both sides of each facet; opened: tets on separated nodes.
    """
    corners = np.sort(half_face_corners(opened, crack_pairs), axis=2)
    return (corners[:, 0] == corners[:, 1]).all(axis=1)
