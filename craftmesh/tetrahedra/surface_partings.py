"""Edges of the surface parted where that leaves fewer flat, poor and stretched tetrahedra."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import front_edges
from craftmesh.tetrahedra.grain_surface import lowest_equal_point
from craftmesh.tetrahedra.kernels.tet_faults import FALL, weigh_all
from craftmesh.tetrahedra.kernels.tet_quality import WHOLE, all_qualities
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import Surface

# Where edges are tried to be parted, as shares of their length, the first where several are as good.
SHARES = (0.5, 0.35, 0.65, 0.2, 0.8)


@dataclass(frozen=True)
class Parting:
    """Edges (k, 2) of a surface, and the shares (k,) of their lengths at which they are parted."""

    edges: np.ndarray
    shares: np.ndarray

    def places(self, points: np.ndarray) -> np.ndarray:
        """Return where the edges are parted (k, 3): on planes of the box that hold both ends, exactly."""
        start, end = points[self.edges[:, 0]], points[self.edges[:, 1]]
        return start + self.shares[:, None] * (end - start)


def worthwhile(model: Model, bad: np.ndarray) -> Parting:
    """Return the edges of the surface at `bad` tets (m,) that are to be parted, and where.

    Those with which the tets round them weigh less by their faults, where they lose most first, and no two
    of one tet. Edges of the front stay.
    """
    return _chosen(model.points, model.tets, bad, inner_edges(model))


def with_edges_parted(model: Model, parting: Parting) -> tuple[Model, np.ndarray]:
    """Return the model with edges of its surface parted, no two of one tet, and the grains changed.

    The new points follow those of the surface, in the order of the edges; facets are parted where they
    are, so that grains and crack keep their shape.
    """
    old, points, grain = model.surface, model.points, model.grain
    edges, count = parting.edges, len(old.points)
    nodes = np.concatenate([points[:count], parting.places(points), points[count:]])
    tets, tet = _cut(np.where(model.tets < count, model.tets, model.tets + len(edges)), edges, count)
    facets, facet = _cut(_one_facets(old), edges, count)
    surface = replace(
        old,
        points=nodes[: count + len(edges)],
        facets=facets.astype(old.facets.dtype),
        sides=old.sides[facet],
        kind=old.kind[facet],
    )
    changed = np.unique(grain[tet[1:][tet[1:] == tet[:-1]]])
    return model.changed(surface, tets, grain[tet], nodes), changed


def _one_facets(surface: Surface) -> np.ndarray:
    """Return the facets (m, 3) of a surface, with one of the points that lie in one place."""
    facets: np.ndarray = lowest_equal_point(surface.points)[surface.facets]
    return facets


def inner_edges(model: Model) -> np.ndarray:
    """Return the edges (e, 2) of the surface's facets that are not of the front."""
    facets = _one_facets(model.surface)
    edges = unique_edges(facets)[0]
    front = front_edges(replace(model.surface, facets=facets))
    key = np.array([len(model.surface.points), 1])
    return edges[~np.isin(edges @ key, front @ key)]


def _chosen(points: np.ndarray, tets: np.ndarray, bad: np.ndarray, edges: np.ndarray) -> Parting:
    """Return those of the edges (e, 2) at bad tets that are to be parted, and where."""
    edges = edges[np.unique(_having(tets[bad], edges)[1])]
    row, edge = _having(tets, edges)
    before = np.bincount(edge, _weights(points[tets[row]]), len(edges))
    tried = np.array(
        [_after(points, tets[row], edge, Parting(edges, np.full(len(edges), s))) for s in SHARES]
    )
    fall = before - tried.min(axis=0)
    worth = np.flatnonzero(fall > FALL)
    taken, chosen = np.zeros(len(tets), bool), []
    for number in worth[np.argsort(-fall[worth], kind="stable")].tolist():
        own = row[edge == number]
        if not taken[own].any():
            taken[own] = True
            chosen.append(number)
    return Parting(edges[chosen], np.array(SHARES)[tried.argmin(axis=0)[chosen]])


def _after(points: np.ndarray, tets: np.ndarray, edge: np.ndarray, parting: Parting) -> np.ndarray:
    """Return what the tets (k, 4), each with an edge (k,), weigh by edge where all edges are parted."""
    places, total = parting.places(points), np.zeros(len(parting.edges))
    for end in parting.edges[edge].T:
        corners = np.where((tets == end[:, None])[..., None], places[edge][:, None], points[tets])
        total += np.bincount(edge, _weights(corners), len(total))
    return total


def _weights(corners: np.ndarray) -> np.ndarray:
    """Return what tets (k, 4, 3) weigh by their faults."""
    quality, weight = np.empty((2, len(corners)))
    tets = np.arange(4 * len(corners)).reshape(-1, 4)
    all_qualities(np.ascontiguousarray(corners.reshape(-1, 3)), tets, len(tets), quality, WHOLE)
    weigh_all(quality, weight)
    return weight


def _having(cells: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of cells (m, 3 or 4) and, with each, that of one of the edges (e, 2), sorted, it has."""
    rows, found = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    if len(edges):
        stride = max(int(cells.max(initial=0)), int(edges.max())) + 1
        keys = edges @ (stride, 1)
        order = np.argsort(keys)
        for pair in combinations(range(cells.shape[1]), 2):
            key = np.sort(cells[:, pair].astype(np.int64), axis=1) @ (stride, 1)
            place = order[np.minimum(np.searchsorted(keys, key, sorter=order), len(keys) - 1)]
            rows.append(np.flatnonzero(keys[place] == key))
            found.append(place[rows[-1]])
    return np.concatenate(rows), np.concatenate(found)


def _cut(cells: np.ndarray, edges: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the cells (m, 3 or 4) parted at new nodes on edges (e, 2), numbered from `first` on.

    With each, the row of the cell that it was part of. No cell has two of the edges.
    """
    row, edge = _having(cells, edges)
    times = np.ones(len(cells), np.int64)
    times[row] = 2
    start = np.cumsum(times) - times
    of_cell = np.repeat(np.arange(len(cells)), times)
    result = cells[of_cell]
    for half, gone in enumerate(edges[edge].T):
        part = result[start[row] + half]
        result[start[row] + half] = np.where(part == gone[:, None], first + edge[:, None], part)
    return result, of_cell
