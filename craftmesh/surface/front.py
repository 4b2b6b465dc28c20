"""The front of a crack in a surface, and the crack's ears.

A front edge has exactly one crack facet and no free facet: the crack ends there, within the material.
Facets of grain boundaries may share the edge where the front runs along a boundary. Boundary edges of the
crack on free facets (of the box, of the exterior, of voids) form its mouth, which opens. Once tetrahedra
are opened along the crack, the front consists of the boundary edges that both crack faces share
(`craftmesh.mesh.front`).

An ear is an edge inside the crack, with two or more crack facets, that joins two front vertices. It stays
shut, as does a facet with all its corners on the front. A facet without an ear has a corner off the front,
and opens. Insertion and gradation split ears, and the gradation makes no new ones.
"""

import numpy as np

from craftmesh.surface.connectivity import facet_edges, unique_edges
from craftmesh.surface.measure import edge_lengths
from craftmesh.types import CRACK, Surface


def front_edges(surface: Surface) -> np.ndarray:
    """Return the front edges (k, 2) int64 of the crack in `surface`, the lower point first, sorted."""
    free = (surface.sides <= 0).any(axis=1)
    return front_of(surface.facets[surface.kind == CRACK], surface.facets[free])


def front_of(crack: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return the front edges (k, 2) of crack facets (c, 3); free (f, 3): facets of exterior and voids."""
    edges, _, count = unique_edges(crack)
    rim = edges[count == 1]
    return rim[~among_edges(rim, free)]


def among_edges(edges: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of the edges (k, 2) that are edges of facets (m, 3)."""
    stride = max(int(edges.max(initial=0)), int(facets.max(initial=0))) + 1
    ends = np.zeros(stride, bool)
    ends[edges] = True
    near = facet_edges(facets[ends[facets].sum(axis=1) >= 2])
    key = np.array([stride, 1])
    return np.isin(np.sort(edges, axis=1) @ key, np.sort(near, axis=1) @ key)


def ears(crack: np.ndarray, on_front: np.ndarray) -> np.ndarray:
    """Return the ears (k, 2) of crack facets (c, 3), the lower point first, sorted.

    on_front (n,): mask of the points on the front.
    """
    edges, _, count = unique_edges(crack)
    return edges[(count > 1) & on_front[edges].all(axis=1)]


def median_front_edge(surface: Surface) -> float:
    """Return the median length of the front's edges, 0 if there is no front."""
    edges = front_edges(surface)
    return float(np.median(edge_lengths(surface.points, edges))) if len(edges) else 0.0
