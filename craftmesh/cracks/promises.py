"""How far a crack in a mesh may be off the given one: what every stage is held to."""

# Of the least target length: facets, and nodes of the front. A measured crack is known no better than to
# some 0.15 edges; K is found along the front.
FACETS_OFF, FRONT_OFF = 0.15, 0.02
# How far of FRONT_OFF a front goes to end on a face, or to close the strip between it and another.
FRONT_MOVED = 0.018
# Of the given area, and of the least target length squared: the area. 0.005 and 0.02 are promised.
AREA_OFF, LEAST_AREA = 0.004, 0.016
