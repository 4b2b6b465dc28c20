"""Facets that two parts of a folded crack have too many or too few where they meet; the whole's fronts."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import among_edges, front_edges
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.types import CRACK, Crack, Surface

STRAY = 0.2  # of the least length: crack edges farther off all given fronts than this are no front
# Of the least length: the width up to which what is open between two parts is closed, and how far off all
# given fronts its edges are, which those of a front never are.
SLIT = 0.02


class Fronts(NamedTuple):
    """All that is front of a surface once a crack is in it: edges (k, 2) between points (n, 3)."""

    points: np.ndarray
    edges: np.ndarray

    def off(self, places: np.ndarray) -> np.ndarray:
        """Return how far places (n, 3) are from the nearest front, infinitely without any."""
        if not len(self.edges) or not len(places):
            return np.full(len(places), np.inf)
        foot = nearest_on_edges(np.ascontiguousarray(places), self.points, self.edges)
        return np.asarray(np.linalg.norm(foot - places, axis=1))


def fronts_of(surface: Surface, crack: Crack) -> Fronts:
    """Return the fronts of a crack, and of those that are in the surface before it comes in."""
    there = front_edges(surface) + len(crack.points)
    points = np.concatenate([crack.points, surface.points])
    return Fronts(points, np.concatenate([crack.front_edges, there]))


def without_fins(surface: Surface, fronts: Fronts, least: float) -> Surface:
    """Return the surface without crack facets that end where no front is and hang on the crack's others.

    Where a kink passes an edge of the box both parts beside it may come in over the same facet: of a kink
    0.008 l_min beside such an edge one was left, its front 7 l_min off the given one. Without it the parts
    meet at its other edge. least: the least target length.
    """
    rows = _fins(surface, fronts, STRAY * least)
    while len(rows):
        kept = np.arange(len(surface.facets)) != rows[0]
        facets, sides, kind = (part[kept] for part in (surface.facets, surface.sides, surface.kind))
        surface = replace(surface, facets=facets, sides=sides, kind=kind)
        rows = _fins(surface, fronts, STRAY * least)
    return surface


def without_slits(surface: Surface, fronts: Fronts, least: float) -> Surface:
    """Return the surface with a crack facet in each narrow triangle between crack edges where no front is.

    Of two parts that met in a kink one had a node 0.005 l_min beside one of the other's, and between the
    edges to these the crack was open. least: the least target length.
    """
    crack = np.flatnonzero(surface.kind == CRACK)
    corners = surface.facets[crack].astype(np.int64)
    halves = {(int(f[k - 1]), int(f[k])): row for row, f in zip(crack, corners) for k in range(3)}
    open_edges = {edge: row for edge, row in halves.items() if edge[::-1] not in halves}
    added, sides = [], []
    for a, b, c in _triangles(_stray(surface, fronts, SLIT * least)):
        if _height(surface.points[[a, b, c]]) > SLIT * least:
            continue
        edge = (a, b) if (a, b) in open_edges else (b, a)
        added.append((*edge[::-1], c))
        sides.append(surface.sides[open_edges[edge]])
    if not added:
        return surface
    return replace(
        surface,
        facets=np.concatenate([surface.facets, np.array(added, surface.facets.dtype)]),
        sides=np.concatenate([surface.sides, np.array(sides, surface.sides.dtype)]),
        kind=np.concatenate([surface.kind, np.full(len(added), CRACK, surface.kind.dtype)]),
    )


def _stray(surface: Surface, fronts: Fronts, far: float) -> np.ndarray:
    """Return the edges (k, 2) where the crack ends and no front is."""
    front = front_edges(surface)
    return front[fronts.off(surface.points[front].mean(axis=1)) > far]


def _triangles(edges: np.ndarray) -> list[tuple[int, int, int]]:
    """Return the triples of points that edges (k, 2) join, each once."""
    near: dict[int, set[int]] = {}
    for a, b in edges.tolist():
        near.setdefault(a, set()).add(b)
        near.setdefault(b, set()).add(a)
    return [(a, b, c) for a, b in edges.tolist() for c in sorted(near[a] & near[b]) if a < b < c]


def _height(corners: np.ndarray) -> float:
    """Return the least height of a triangle (3, 3)."""
    longest = np.linalg.norm(corners - corners[[1, 2, 0]], axis=1).max()
    area2 = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    return float(area2 / longest)


def _fins(surface: Surface, fronts: Fronts, far: float) -> np.ndarray:
    """Return the rows of crack facets that may go: one edge off all fronts, the others held without it."""
    stray = _stray(surface, fronts, far)
    crack = np.flatnonzero(surface.kind == CRACK)
    if not len(stray):
        return crack[:0]
    edges, of_corner, count = unique_edges(surface.facets[crack])
    key = np.array([len(surface.points), 1])
    ends = np.isin(edges @ key, stray @ key)
    held = ends | (count > 2) | among_edges(edges, surface.facets[(surface.sides <= 0).any(axis=1)])
    return crack[ends[of_corner].any(axis=1) & held[of_corner].all(axis=1)]
