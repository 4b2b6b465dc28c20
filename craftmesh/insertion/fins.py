"""Facets that two parts of a folded crack have too many or too few where they meet; the whole's fronts."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import among_edges, front_edges
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.types import CRACK, Crack, Surface

STRAY = 0.2  # of the least length: crack edges farther off all given fronts than this are no front


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


def _fins(surface: Surface, fronts: Fronts, far: float) -> np.ndarray:
    """Return the rows of crack facets that may go: one edge off all fronts, the others held without it."""
    front = front_edges(surface)
    stray = front[fronts.off(surface.points[front].mean(axis=1)) > far]  # the crack ends, and no front is
    crack = np.flatnonzero(surface.kind == CRACK)
    if not len(stray):
        return crack[:0]
    edges, of_corner, count = unique_edges(surface.facets[crack])
    key = np.array([len(surface.points), 1])
    ends = np.isin(edges @ key, stray @ key)
    held = ends | (count > 2) | among_edges(edges, surface.facets[(surface.sides <= 0).any(axis=1)])
    return crack[ends[of_corner].any(axis=1) & held[of_corner].all(axis=1)]
