"""Patches, junction lines and topology of surfaces, plainly, without the product's kernels."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from craftmesh.types import Surface


def edge_table(facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the edges (e, 2), lower id first, and of each facet corner the edge that starts there."""
    directed = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    width = int(directed.max()) + 1
    keys, of = np.unique(directed.min(axis=1) * width + directed.max(axis=1), return_inverse=True)
    return np.stack([keys // width, keys % width], axis=1), of.reshape(-1, 3)


def patch_keys(surface: Surface) -> list[tuple]:
    """Return per facet its pair of sides, the larger first, and its kind."""
    high, low = surface.sides.max(axis=1), surface.sides.min(axis=1)
    return list(zip(high.tolist(), low.tolist(), surface.kind.tolist()))


def patches(surface: Surface) -> dict[tuple, np.ndarray]:
    """Return patch key -> rows of its facets."""
    rows = {}
    for row, key in enumerate(patch_keys(surface)):
        rows.setdefault(key, []).append(row)
    return {key: np.array(found) for key, found in rows.items()}


def lines(surface: Surface) -> np.ndarray:
    """Return the feature edges (k, 2): not between two facets of one patch."""
    edges, of = edge_table(surface.facets)
    number = {key: i for i, key in enumerate(dict.fromkeys(patch_keys(surface)))}
    patch = np.repeat([number[key] for key in patch_keys(surface)], 3)
    low, high = np.full(len(edges), len(number)), np.full(len(edges), -1)
    np.minimum.at(low, of.ravel(), patch)
    np.maximum.at(high, of.ravel(), patch)
    return edges[(np.bincount(of.ravel()) != 2) | (low != high)]


def components(links: np.ndarray, nodes: np.ndarray) -> int:
    """Return the number of components of the graph with edges `links` (k, 2) on `nodes`."""
    size = int(nodes.max(initial=-1)) + 1
    graph = coo_matrix((np.ones(len(links), np.int8), (links[:, 0], links[:, 1])), shape=(size, size))
    return len(np.unique(connected_components(graph, directed=False)[1][nodes]))


def euler_number(facets: np.ndarray) -> int:
    return len(np.unique(facets)) - len(edge_table(facets)[0]) + len(facets)


def sheets(facets: np.ndarray) -> int:
    """Return how many parts facets joined over edges make."""
    edges, of = edge_table(facets)
    rows = np.repeat(np.arange(len(facets)), 3)
    links = np.stack([rows, len(facets) + of.ravel()], axis=1)
    return components(links, np.arange(len(facets) + len(edges)))


def topology(surface: Surface) -> dict[tuple, tuple]:
    """Return Euler number and parts of each label's boundary and of each patch (a contact)."""
    facets = surface.facets.astype(np.int64)
    found = {}
    bounds = surface.sides[:, 0] != surface.sides[:, 1]
    for label in np.unique(surface.sides).tolist():
        mine = facets[(surface.sides == label).any(axis=1) & bounds]
        if len(mine):
            found["label", label] = euler_number(mine), sheets(mine)
    for key, rows in patches(surface).items():
        found["patch", key] = euler_number(facets[rows]), sheets(facets[rows])
    return found


def open_edges(surface: Surface) -> list[str]:
    """Return the labels round which a directed edge lacks its partner."""
    breaches = []
    facets = surface.facets.astype(np.int64)
    bounds = surface.sides[:, 0] != surface.sides[:, 1]
    for label in np.unique(surface.sides).tolist():
        behind = facets[bounds & (surface.sides[:, 0] == label)]
        ahead = facets[bounds & (surface.sides[:, 1] == label)][:, ::-1]
        mine = np.concatenate([behind, ahead])
        balance = {}
        for a, b in np.stack([mine, np.roll(mine, -1, axis=1)], axis=2).reshape(-1, 2).tolist():
            key, turn = ((a, b), 1) if a < b else ((b, a), -1)
            balance[key] = balance.get(key, 0) + turn
        count = sum(v != 0 for v in balance.values())
        if count:
            breaches.append(f"label {label} has {count} open edges")
    return breaches


def tied_vertices(surface: Surface) -> dict[int, int]:
    """Return per grain the number of vertices at which its boundary touches itself; others are left out.

    Corners of facets at a vertex hang together over edges with two facets of the grain's boundary; a
    vertex with more than one such fan is tied.
    """
    tied = {}
    for grain in surface.grains.tolist():
        facets = surface.facets[(surface.sides == grain).sum(axis=1) == 1]
        edges, of = edge_table(facets)
        met = [[] for _ in edges]
        for f, row in enumerate(of.tolist()):
            for i, edge in enumerate(row):
                met[edge].append((f, i))
        links = []
        for pair in met:
            if len(pair) == 2:
                (f, i), (g, j) = pair
                for a in (i, (i + 1) % 3):
                    b = next(b for b in (j, (j + 1) % 3) if facets[g, b] == facets[f, a])
                    links.append((3 * f + a, 3 * g + b))
        rows, columns = np.array(links, int).reshape(-1, 2).T
        graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(facets.size, facets.size))
        fan = connected_components(graph, directed=False)[1]
        fans = {(v, k) for v, k in zip(facets.ravel().tolist(), fan.tolist())}
        count = np.bincount([v for v, _ in fans])
        if (count > 1).any():
            tied[grain] = int((count > 1).sum())
    return tied
