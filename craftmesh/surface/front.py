"""The front of a crack in a surface, and the crack's ears.

A front edge is an edge on which exactly one crack facet lies and no facet that is free: the crack ends
there, within the material. Facets of grain boundaries may lie on it as well, where the front runs along
one. A rim of the crack on free facets, those of the box, of the exterior and of voids, is its mouth: it
opens. Once tetrahedra are opened along the crack, the same edges are those on the rim of one lip that both
lips share (`craftmesh.mesh.front`).

An ear is an edge inside the crack, with two crack facets or more on it, that joins two vertices of the
front. It stays shut, and so does a facet with all its corners on the front; a facet without an ear has a
corner off the front, and opens. Insertion and gradation split ears, and the gradation makes no new ones.
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
    """Return the front edges (k, 2) of crack facets (c, 3) where the facets (f, 3) are free."""
    edges, _, count = unique_edges(crack)
    rim = edges[count == 1]
    return rim[~among_edges(rim, free)]


def among_edges(edges: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Tell which edges (k, 2) are edges of facets (m, 3)."""
    stride = max(int(edges.max(initial=0)), int(facets.max(initial=0))) + 1
    ends = np.zeros(stride, bool)
    ends[edges] = True
    near = facet_edges(facets[ends[facets].sum(axis=1) >= 2])
    key = np.array([stride, 1])
    return np.isin(np.sort(edges, axis=1) @ key, np.sort(near, axis=1) @ key)


def ears(crack: np.ndarray, on_front: np.ndarray) -> np.ndarray:
    """Return the ears (k, 2) of crack facets (c, 3), the lower point first, sorted.

    on_front (n,) bool: points that front edges end at.
    """
    edges, _, count = unique_edges(crack)
    return edges[(count > 1) & on_front[edges].all(axis=1)]


def median_front_edge(surface: Surface) -> float:
    """Return the median length of the front's edges, 0 without a front."""
    edges = front_edges(surface)
    return float(np.median(edge_lengths(surface.points, edges))) if len(edges) else 0.0
