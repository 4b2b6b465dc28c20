"""The patches of a surface, the feature edges where they meet, and box planes."""

from typing import NamedTuple

import numpy as np

from craftmesh.surface.connectivity import touching, unique_edges
from craftmesh.surface.measure import numbered
from craftmesh.types import BOX_PLANES, CRACK, INTERFACE, Surface

# For each plane of the box its kind, its axis and whether it is the upper one of the axis' two.
PLANES = tuple((kind, (kind - 1) // 2, kind % 2 == 0) for kind in range(1, len(BOX_PLANES) + 1))


def is_on_box(kind: np.ndarray) -> np.ndarray:
    """Return (m,) bool: facets of these kinds (m,) that lie on a plane of the box."""
    return (kind > INTERFACE) & (kind < CRACK)


def box_axis(kind: np.ndarray) -> np.ndarray:
    """Return (m,) int64 the axis to which the plane of the box of each facet is normal; -1 off the box."""
    return np.where(is_on_box(kind), (kind.astype(np.int64) - 1) // 2, -1)


def oriented(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return facets (m, 3) and sides (m, 2) with the larger label behind each normal.

    Crack facets stay as they are: their sides are the crack's lips.
    """
    turned = _turned(surface)[:, None]
    facets = np.where(turned, surface.facets[:, ::-1], surface.facets)
    return facets, np.where(turned, surface.sides[:, ::-1], surface.sides)


def _turned(surface: Surface) -> np.ndarray:
    return (surface.sides[:, 0] < surface.sides[:, 1]) & (surface.kind != CRACK)


class Patches(NamedTuple):
    """of_facet (m,) int64: each facet's patch, from 0; first_facet (p,): the first facet of each patch."""

    of_facet: np.ndarray
    first_facet: np.ndarray


def patches(surface: Surface) -> Patches:
    """Return the patches of a surface: facets between the same two labels and of one kind.

    Which way a facet is turned makes no difference, but on the crack, whose two lips are told apart.
    Patches are numbered in the order of their larger label, smaller label and kind.
    """
    sides = np.where(_turned(surface)[:, None], surface.sides[:, ::-1], surface.sides)
    labels, place = numbered(sides)
    key = (place[:, 0] * len(labels) + place[:, 1]) * (CRACK + 1) + surface.kind
    start = np.flatnonzero(np.r_[True, key[1:] != key[:-1]][: len(key)])
    _, first, patch = np.unique(key[start], return_index=True, return_inverse=True)
    of_facet = np.repeat(patch.reshape(-1), np.diff(start, append=len(key))).astype(np.int64)
    return Patches(of_facet, start[first])


class FeatureEdges(NamedTuple):
    """The edges of a surface, and which of them bound patches.

    edges (e, 2), of_corner (m, 3), facets_on (e,): as `unique_edges` gives them. is_feature (e,) bool:
    edges where other than two facets of one patch meet.
    """

    edges: np.ndarray
    of_corner: np.ndarray
    facets_on: np.ndarray
    is_feature: np.ndarray

    @property
    def lines(self) -> np.ndarray:
        """(k, 2) the feature edges alone."""
        return self.edges[self.is_feature]


def feature_edges(surface: Surface, of_facet: np.ndarray | None = None) -> FeatureEdges:
    """Return the edges of `surface` and which are features; of_facet (m,): its patches, where known."""
    patch = patches(surface).of_facet if of_facet is None else of_facet
    edges, of_corner, count = unique_edges(surface.facets)
    any_patch = np.empty(len(edges), np.int64)
    any_patch[of_corner] = patch[:, None]
    is_feature = count != 2
    is_feature[of_corner[any_patch[of_corner] != patch[:, None]]] = True
    return FeatureEdges(edges, of_corner, count, is_feature)


def facets_beyond_box(
    moved: np.ndarray, points: np.ndarray, facets: np.ndarray, kind: np.ndarray
) -> np.ndarray:
    """Return (m,) bool: facets (m, 3) of kind (m,) with a vertex past a plane of the box (one with facets).

    points (n, 3): the vertices before, `moved` (n, 3) the same ones now.
    """
    beyond = np.zeros(len(points), bool)
    for plane, axis, upper in PLANES:
        on_plane = facets[kind == plane]
        if len(on_plane):
            level = points[on_plane[0, 0], axis]
            beyond |= moved[:, axis] > level if upper else moved[:, axis] < level
    return touching(facets, beyond)
