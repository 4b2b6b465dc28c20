"""Gaps between the front of a crack and another crack, or a face of the box: edges are short there."""

from dataclasses import replace

import numpy as np

from craftmesh.sizing.sizing import Sizing, where_short
from craftmesh.surface.connectivity import edge_sides, joined, unique_edges
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import distances_and_sides
from craftmesh.types import BOX_FACES, CRACK, Surface

# Times the gap. Of 48 pairs of discs that touch or nearly do nine had 2 to 16 flat tets; in five of them
# the front ran 0.03 l_min beside the other crack, and none is left there. With 6 they were as sound, with
# more tets over an aspect ratio of 5. Of 26 discs whose fronts come to 0.012 to 0.08 l_min from a face, at
# 25, 50 and 90 degrees to it, twelve had 1 to 7 where nothing else makes edges short there, and none is
# left; where the sizing does for strips the least dihedral angles rise from 5 to 11 degrees to 7 to 14.
PER_GAP = 4.0
LEAST = 0.1  # of l_min: edges in gaps are no shorter


def short_in_gaps(surface: Surface, sizing: Sizing) -> Sizing:
    """Return the sizing with edges of PER_GAP, at least LEAST l_min, where a front is beside something.

    That is another crack or a face of the box. Cracks are what hangs together across edges of two crack
    facets: of two that cross the tip beyond is one. Edges that meet the other crack, or the face, count for
    nothing: with them cracks at 8 to 12 degrees to a face had more flat tets, not fewer.
    """
    edges = front_edges(surface)
    found = [*_beside_cracks(surface, edges), *_beside_faces(surface, edges)]
    places, gaps = (np.concatenate(one) for one in zip(*found))
    short = where_short(places, np.maximum(PER_GAP * gaps, LEAST * sizing.l_min), sizing)
    return sizing if short is None else replace(sizing, others=(*sizing.others, short))


def _beside_cracks(surface: Surface, edges: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the places and gaps where front edges (k, 2) of one crack are beside another."""
    facets = surface.facets[surface.kind == CRACK].astype(np.int64)
    piece = _pieces(facets)
    found = []
    for number in range(int(piece.max(initial=-1)) + 1):
        others = facets[piece != number]
        own = edges[~np.isin(edges, others).any(axis=1)]
        if len(own) and len(others):
            at = _along(surface.points[own])
            gaps = distances_and_sides(at.reshape(-1, 3), surface.points, others)[0]
            found.append(_narrow(at, gaps.reshape(-1, 3)))
    return found


def _beside_faces(surface: Surface, edges: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the places and gaps where front edges (k, 2) are beside a face of the box."""
    box, at, found = surface.box, _along(surface.points[edges]), []
    for axis, upper in BOX_FACES:
        gaps = np.abs(at[..., axis] - box[upper, axis])
        apart = (gaps > 0).all(axis=1)
        found.append(_narrow(at[apart], gaps[apart]))
    return found


def _along(ends: np.ndarray) -> np.ndarray:
    """Return the ends and middles (k, 3, 3) of edges (k, 2, 3)."""
    return np.concatenate([ends, ends.mean(axis=1, keepdims=True)], axis=1)


def _narrow(at: np.ndarray, gaps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (m, 3) and gaps (m,) on edges that are longer than PER_GAP their gap."""
    beside = PER_GAP * gaps.max(axis=1) < np.linalg.norm(at[:, 1] - at[:, 0], axis=1)
    return at[beside].reshape(-1, 3), gaps[beside].ravel()


def _pieces(facets: np.ndarray) -> np.ndarray:
    """Return the piece (m,) of each crack facet (m, 3): what hangs together across edges of two facets."""
    _, of_corner, count = unique_edges(facets)
    f, g = (side // 3 for side in edge_sides(of_corner, count == 2))
    return joined(len(facets), f, g)
