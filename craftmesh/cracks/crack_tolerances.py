"""Tolerances between the crack in the mesh and the given crack, and each stage's share of them.

The stages run one after another, and each measures against the crack that it receives. Their shares add up
to at most the promised tolerance. docs/architecture.md has the table.
"""

from typing import NamedTuple


class Off(NamedTuple):
    """Largest distances of facet samples and front nodes from the given crack.

    The unit is the smallest target length.
    """

    facets: float
    front: float


# Tolerance of the final mesh. A measured crack is known to about 0.15 edges; K needs a more exact front.
PROMISED = Off(facets=0.15, front=0.02)
# Share of the preparation: it ends fronts on faces that they graze, fills strips between surfaces, and
# merges surfaces that overlap.
PREPARATION = Off(facets=0.02, front=0.0175)
# Share of the insertion: nodes are put on the front, or within 1e-3 edges where a trace nearly touches it.
INSERTION = Off(facets=0.105, front=0.0015)
# Share of later cracks: inserting one moves points of an earlier crack along that crack.
LATER_CRACKS = Off(facets=0.005, front=0.0005)
# Share of the gradation: a new facet may be as far off as any sample of the facets that it replaces. At
# middles of edges and facets, this adds up to 0.015 in the worst of the random cracks (seed 103). The
# front's curve is replaced by segments.
GRADATION = Off(facets=0.015, front=0.0005)
# Share of the tetrahedra: with ten times as much, tetrahedra get no better.
TETRAHEDRA = Off(facets=0.005, front=0.0)
SHARES = {
    "preparation": PREPARATION,
    "insertion": INSERTION,
    "later cracks": LATER_CRACKS,
    "gradation": GRADATION,
    "tetrahedra": TETRAHEDRA,
}

# Largest distance, in smallest target lengths, to which the gradation takes facets that were nearer to the
# given crack. With 0.045 they were up to 0.053 off between the samples that are measured.
GRADATED = 0.04
# Largest distance of inserted front edges from the front between their nodes, in target lengths.
FRONT_EDGES = 0.98 * PROMISED.front
# Largest area error: a fraction of the given area or of the smallest target length squared, whichever is
# larger. Insertion and gradation keep to the fraction AREA_KEPT of it.
AREA_PROMISED, LEAST_AREA_PROMISED = 0.005, 0.02
AREA_KEPT = 0.8
