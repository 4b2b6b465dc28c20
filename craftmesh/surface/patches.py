"""The patches of a surface, the feature edges where patches meet, and box planes."""

from typing import NamedTuple

import numpy as np

from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import numbered
from craftmesh.types import BORDER, BOX_PLANES, CRACK, INTERFACE, Surface

# For each box plane: its kind, the axis normal to it, and whether it is the upper of the two.
PLANES = tuple((kind, (kind - 1) // 2, kind % 2 == 0) for kind in range(1, len(BOX_PLANES) + 1))


def is_on_box(kind: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of facets that lie on a box plane, by their kind (m,)."""
    return (kind > INTERFACE) & (kind < CRACK)


def box_axis(kind: np.ndarray) -> np.ndarray:
    """Return the axis (m,) normal to the box plane of each facet, by its kind (m,); -1 off the box."""
    return np.where(is_on_box(kind), (kind.astype(np.int64) - 1) // 2, -1)


def oriented(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return facets (m, 3) and sides (m, 2) with the larger label behind each normal.

    Crack facets are unchanged, because their sides are the crack faces.
    """
    turned = ((surface.sides[:, 0] < surface.sides[:, 1]) & (surface.kind != CRACK))[:, None]
    if not turned.any():
        return surface.facets, surface.sides
    facets = np.where(turned, surface.facets[:, ::-1], surface.facets)
    return facets, np.where(turned, surface.sides[:, ::-1], surface.sides)


class Patches(NamedTuple):
    """The patches: of_facet (m,), each facet's patch from 0; first_facet (p,), each patch's first facet."""

    of_facet: np.ndarray
    first_facet: np.ndarray


def patches(surface: Surface) -> Patches:
    """Return the patches of a surface: sets of facets between the same two labels and of one kind.

    The orientation of a facet makes no difference, except on the crack, whose two faces are distinguished.
    Patches are numbered in the order of their larger label, smaller label and kind. Each border facet
    (where a part was cut out of a mesh) is a patch of its own, so that all its edges are feature edges.
    """
    labels, place = numbered(oriented(surface)[1])
    key = (place[:, 0] * len(labels) + place[:, 1]) * (BORDER + 1) + surface.kind
    border = surface.kind == BORDER
    key[border] = (BORDER + 1) * len(labels) ** 2 + np.arange(int(border.sum()))
    start = np.flatnonzero(np.r_[True, key[1:] != key[:-1]][: len(key)])
    _, first, patch = np.unique(key[start], return_index=True, return_inverse=True)
    of_facet = np.repeat(patch.reshape(-1), np.diff(start, append=len(key)))
    return Patches(of_facet, start[first])


class FeatureEdges(NamedTuple):
    """The edges of a surface, with a mask of those that bound patches.

    edges (e, 2), of_corner (m, 3), facets_on (e,): as from `unique_edges`. is_feature (e,): mask of edges
    that are not between exactly two facets of one patch.
    """

    edges: np.ndarray
    of_corner: np.ndarray
    facets_on: np.ndarray
    is_feature: np.ndarray

    @property
    def lines(self) -> np.ndarray:
        """(k, 2) the feature edges."""
        return self.edges[self.is_feature]


def feature_edges(surface: Surface, of_facet: np.ndarray | None = None) -> FeatureEdges:
    """Return the edges of `surface` with a mask of feature edges; of_facet (m,): its patches, if known."""
    patch = patches(surface).of_facet if of_facet is None else of_facet
    edges, of_corner, count = unique_edges(surface.facets)
    any_patch = np.empty(len(edges), np.int64)
    any_patch[of_corner] = patch[:, None]
    is_feature = count != 2
    is_feature[of_corner[any_patch[of_corner] != patch[:, None]]] = True
    return FeatureEdges(edges, of_corner, count, is_feature)


def box_levels(surface: Surface) -> np.ndarray:
    """Return the bounds (2, 3) of the box, infinite where no facet lies on its plane."""
    levels = np.array([[-np.inf] * 3, [np.inf] * 3])
    for plane, axis, upper in PLANES:
        on_plane = surface.facets[surface.kind == plane]
        if len(on_plane):
            levels[int(upper), axis] = surface.points[on_plane[0, 0], axis]
    return levels
