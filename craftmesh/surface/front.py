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
from craftmesh.types import CRACK, Surface


def front_edges(surface: Surface) -> np.ndarray:
    """Return the front edges (k, 2) int64 of the crack in `surface`, the lower point first, sorted."""
    free = (surface.sides <= 0).any(axis=1)
    return front_of(surface.facets[surface.kind == CRACK], surface.facets[free])


def front_of(crack: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return the front edges (k, 2) of crack facets (c, 3) where the facets (f, 3) are free."""
    edges, _, count = unique_edges(crack)
    rim = edges[count == 1]
    stride = max(int(crack.max(initial=0)), int(free.max(initial=0))) + 1
    at_rim = np.zeros(stride, bool)
    at_rim[rim] = True
    at_free = np.sort(facet_edges(free[at_rim[free].sum(axis=1) >= 2]), axis=1)
    key = np.array([stride, 1])
    return rim[~np.isin(rim @ key, at_free @ key)]


def ears(crack: np.ndarray, on_front: np.ndarray) -> np.ndarray:
    """Return the ears (k, 2) of crack facets (c, 3), the lower point first, sorted.

    on_front (n,) bool: points that front edges end at.
    """
    edges, _, count = unique_edges(crack)
    return edges[(count > 1) & on_front[edges].all(axis=1)]


def median_front_edge(surface: Surface) -> float:
    """Return the median length of the front's edges, 0 without a front."""
    ends = surface.points[front_edges(surface)]
    return float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))) if len(ends) else 0.0
