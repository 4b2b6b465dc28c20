"""Reference for grain boundaries: their vertices are put back on the patches of a given surface."""

from dataclasses import replace

import numpy as np

from craftmesh.cracks.near_sheet import closest_points_on_triangles
from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.classification import Classification
from craftmesh.surface.guarded_move import RESTORING, guarded_move
from craftmesh.surface.measure import nearest_facet, shortened
from craftmesh.surface.patches import oriented
from craftmesh.types import INTERFACE, Surface

# Largest move of a vertex in target lengths, because the insertion may have moved it onto a crack.
REACH = 0.3
# Moves of a vertex to the mean of the nearest points on its patches. At a junction line of three patches at
# 120 degrees, each of them leaves a third of the distance from the line.
MEANS = 3


def put_on_patches(surface: Surface, reference: Surface, sizing: Lengths) -> Surface:
    """Return `surface` with its vertices on grain boundaries and voids moved onto those of `reference`.

    A vertex moves onto the facets of `reference` that lie between the same two labels. A vertex on a
    junction line or at a junction moves as close as possible to the facets of all its pairs of labels.
    Vertices of the crack and of the border stay. Vertices on box planes stay on them. No facet breaks the
    bounds RESTORING.
    """
    free, places = Classification(surface).free, surface.points
    own, given = _boundaries(surface), _boundaries(reference)
    pairs = [(np.unique(facets), given[labels]) for labels, facets in own.items() if labels in given]
    for _ in range(MEANS):
        total, count = np.zeros(places.shape), np.zeros((len(places), 1))
        for rows, facets in pairs:
            nearest = nearest_facet(places[rows], reference.points, facets)[0]
            total[rows] += closest_points_on_triangles(places[rows], reference.points[facets[nearest]])[0]
            count[rows] += 1
        places = np.where(free & (count > 0), total / np.maximum(count, 1), places)
    reach = REACH * sizing.at(surface.points)
    places = surface.points + shortened(places - surface.points, reach)
    return replace(surface, points=guarded_move(surface, places, RESTORING)[0])


def _boundaries(surface: Surface) -> dict[tuple[int, ...], np.ndarray]:
    """Return the facets (k, 3) inside the box that bound grains, without the crack, by their two labels."""
    facets, sides = (rows[surface.kind == INTERFACE] for rows in oriented(surface))
    order = np.lexsort(sides.T)
    facets, sides = facets[order].astype(np.int64), sides[order]
    first = np.flatnonzero((np.diff(sides, axis=0, prepend=sides[:1] - 1) != 0).any(axis=1))
    return {tuple(sides[row].tolist()): part for row, part in zip(first, np.split(facets, first[1:]))}
