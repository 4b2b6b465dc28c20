"""Wedges: the dihedral angles of grains between neighbouring facets around an edge."""

from typing import NamedTuple

import numpy as np

from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.kernels.hinges import SHARP_COSINE, SHARP_WEDGE, sharp_edges
from craftmesh.types import Surface


class Wedges(NamedTuple):
    """Sectors between consecutive facets around edges.

    edge (w, 2): the points of a sector's edge; label (w,): what fills the sector, grain k, void -k or
    exterior 0; angle (w,): in degrees.
    """

    edge: np.ndarray
    label: np.ndarray
    angle: np.ndarray

    def where(self, chosen: np.ndarray) -> "Wedges":
        """Return the rows that an index or mask chooses."""
        return Wedges(*(column[chosen] for column in self))


def wedges(points: np.ndarray, facets: np.ndarray, sides: np.ndarray, chosen: np.ndarray) -> Wedges:
    """Return the sectors around the edges in `chosen` (c, 2), lower point first.

    points (n, 3), facets (m, 3); sides (m, 2): labels behind and ahead of each facet's normal. An edge with
    one facet has one sector of 360 degrees.
    """
    edges, of_corner, _ = unique_edges(facets)
    stride = len(points) + 1
    wanted = np.isin(edges[:, 0] * stride + edges[:, 1], chosen[:, 0] * stride + chosen[:, 1])
    facet, corner = np.nonzero(wanted[of_corner])
    edge = of_corner[facet, corner]
    far = facets[facet, (corner + 2) % 3]
    forward = facets[facet, corner] == edges[edge, 0]
    start = points[edges[edge, 0]]
    axis = points[edges[edge, 1]] - start
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    arm = points[far] - start
    arm -= np.einsum("ij,ij->i", arm, axis)[:, None] * axis
    first = np.full(len(edges), len(edge))
    np.minimum.at(first, edge, np.arange(len(edge)))
    ahead = arm[first[edge]]
    turn = np.arctan2(np.einsum("ij,ij->i", np.cross(ahead, arm), axis), np.einsum("ij,ij->i", ahead, arm))
    turn = np.where(first[edge] == np.arange(len(edge)), 0.0, turn % (2 * np.pi))
    order = np.lexsort((facet, turn, edge))
    following = np.roll(order, -1)
    last = np.append(edge[order][1:] != edge[order][:-1], True)[: len(order)]
    heads = np.flatnonzero(np.append(True, last)[: len(order)])
    following[last] = order[heads]
    angle = turn[following] - turn[order] + np.where(last, 2 * np.pi, 0.0)
    label = sides[facet, np.where(forward, 1, 0)]
    return Wedges(edges[edge[order]], label[order], np.degrees(angle))


def sharp_wedges(surface: Surface) -> Wedges:
    """Return the wedges of grains and voids below SHARP_WEDGE degrees, the sharpest first."""
    facets = surface.facets.astype(np.int64)
    edges = np.unique(sharp_edges(surface.points, facets, SHARP_COSINE), axis=0)
    at_edge = np.zeros(len(surface.points), bool)
    at_edge[edges] = True
    near = np.flatnonzero(at_edge[facets].sum(axis=1) > 1)
    found = wedges(surface.points, facets[near], surface.sides[near], edges)
    found = found.where((found.label != 0) & (found.angle < SHARP_WEDGE))
    return found.where(np.argsort(found.angle, kind="stable"))
