"""Gaps between the front of one crack and another crack: edges are short there."""

from dataclasses import replace

import numpy as np

from craftmesh.sizing.local_lengths import where_short
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.connectivity import edge_sides, joined, unique_edges
from craftmesh.surface.distances import distances_and_sides
from craftmesh.surface.front import front_edges
from craftmesh.types import CRACK, Surface

# Times the gap. Of 48 pairs of discs that touch or nearly do nine had 2 to 16 flat tets; in five of them
# the front ran 0.03 l_min beside the other crack, and none is left there. With 6 they were as sound, with
# more tets over an aspect ratio of 5.
PER_GAP = 4.0
LEAST = 0.1  # of l_min: edges in gaps are no shorter


def short_in_gaps(surface: Surface, sizing: Sizing) -> Sizing:
    """Return the sizing with edges of PER_GAP, at least LEAST l_min, where a front is beside another crack.

    Cracks are what hangs together across edges of two crack facets: of two that cross the tip beyond is
    one. Edges that meet the other crack count for nothing.
    """
    facets = surface.facets[surface.kind == CRACK].astype(np.int64)
    piece = _pieces(facets)
    if piece.max(initial=0) == 0:
        return sizing
    edges = front_edges(surface)
    places, lengths = [np.zeros((0, 3))], [np.zeros(0)]
    for number in range(int(piece.max()) + 1):
        others = facets[piece != number]
        own = edges[~np.isin(edges, others).any(axis=1)]
        if not len(own):
            continue
        ends = surface.points[own]
        at = np.concatenate([ends, ends.mean(axis=1, keepdims=True)], axis=1)
        gaps = distances_and_sides(at.reshape(-1, 3), surface.points, others)[0].reshape(-1, 3)
        beside = PER_GAP * gaps.max(axis=1) < np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        places.append(at[beside].reshape(-1, 3))
        lengths.append(np.maximum(PER_GAP * gaps[beside].ravel(), LEAST * sizing.l_min))
    short = where_short(np.concatenate(places), np.concatenate(lengths), sizing)
    return sizing if short is None else replace(sizing, others=(*sizing.others, short))


def _pieces(facets: np.ndarray) -> np.ndarray:
    """Return the piece (m,) of each crack facet (m, 3): what hangs together across edges of two facets."""
    _, of_corner, count = unique_edges(facets)
    f, g = (side // 3 for side in edge_sides(of_corner, count == 2))
    return joined(len(facets), f, g)
