"""How far a crack in a mesh may be off the given one, and which stage may spend how much of that.

The stages spend one after another, each against the crack as it came to it. Their shares add up to no more
than what is promised. docs/architecture.md has the table.
"""

from typing import NamedTuple


class Off(NamedTuple):
    """How far places of facets, and nodes of the front, may be off, over the least target length."""

    facets: float
    front: float


# A measured crack is known no better than to some 0.15 edges; K is found along the front.
PROMISED = Off(facets=0.15, front=0.02)
# Fronts end on faces that they graze, strips between sheets are filled; sheets that overlap become one.
PREPARATION = Off(facets=0.02, front=0.0175)
# Nodes of the front come in on it, but for 1e-3 of an edge where a trace nearly touches it.
INSERTION = Off(facets=0.105, front=0.0015)
# Points of a crack that is in the surface already slide along it where another comes in.
LATER_CRACKS = Off(facets=0.005, front=0.0005)
# New facets may lie as far off as those that they replace do at any place: at middles of edges and facets
# that is up to 0.015 more, on seed 103 of the random cracks. The front's curve is replaced by segments.
GRADATION = Off(facets=0.015, front=0.0005)
# Ten times that gains nothing.
TETRAHEDRA = Off(facets=0.005, front=0.0)
SHARES = {
    "preparation": PREPARATION,
    "insertion": INSERTION,
    "later cracks": LATER_CRACKS,
    "gradation": GRADATION,
    "tetrahedra": TETRAHEDRA,
}

# Over the least target length: how far the gradation takes facets off the given crack, where insertion left
# them nearer. With 0.045 they were up to 0.053 off between the places that are measured.
GRADATED = 0.04
# Over the target length: how far front edges are off the front between their nodes, as they come in.
FRONT_EDGES = 0.98 * PROMISED.front
# How far the area may be off, over the given one or the least target length squared, whichever is more.
# Insertion and gradation keep to a part of that.
AREA_PROMISED, LEAST_AREA_PROMISED = 0.005, 0.02
AREA_KEPT = 0.8
