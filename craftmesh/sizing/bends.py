"""Shorter edges where a crack is curved: facets of long ones would leave it."""

import numpy as np

from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.local_lengths import where_short
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.measure import unit_normals
from craftmesh.types import Crack

# Of l_min: how far the middle of an edge may be off a curved crack. The gradation keeps facets within
# 0.04: where it is to make longer ones it leaves facets as they are. Three twisted cracks with l_max of 4
# to 14 l_min had 0.38, 0.17 and 0.27 % of their tets over an aspect ratio of 5, now 0.25, 0.12 and 0.23 %,
# with 2 % more of them; rough cracks keep their number.
OFF = 0.04
# Degrees: a crack that turns by more at an edge has a kink there, which is a line of facets, not a bend.
KINK = 15.0


def bend_lengths(crack: Crack, box: np.ndarray, sizing: Sizing) -> LengthField | None:
    """Return the lengths of edges whose middles are OFF a curved crack; None where no others are longer.

    A chord of length L is L^2 kappa / 8 off a curve of curvature kappa; where the crack turns from one of
    its triangles to the next, kappa is the turn over the distance of their centres. Lengths are l_min at
    least, at places on the crack in the box (2, 3).
    """
    triangles = crack.triangles.astype(np.int64)
    edges, of_corner, count = unique_edges(triangles)
    f, g = (side // 3 for side in edge_sides(of_corner, count == 2))
    places = crack.points[edges[count == 2]].mean(axis=1)
    normal, centre = unit_normals(crack.points, triangles), crack.points[triangles].mean(axis=1)
    turn = 2 * np.arcsin(np.minimum(np.linalg.norm(normal[f] - normal[g], axis=1) / 2, 1.0))
    apart = np.linalg.norm(centre[f] - centre[g], axis=1)
    inside = ((places >= box[0]) & (places <= box[1])).all(axis=1)
    bent = np.flatnonzero((turn > 0) & (turn < np.radians(KINK)) & inside)
    lengths = np.sqrt(8 * OFF * sizing.l_min * apart[bent] / turn[bent])
    return where_short(places[bent], np.maximum(lengths, sizing.l_min), sizing)
