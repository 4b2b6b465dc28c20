"""One conformal surface from the surfaces of the grains.

`stitch` turns a closed surface per grain into one surface that stores both sides of each facet. Points
within the tolerance become one point; facets of two grains with the same corners become one facet. A facet
of only one grain lies on the box, on the outside or on a void (`outer_shells`). The planes of the box are
made exact. Grains that do not match, intersect or do not touch raise an error with their ids, the place
and an advice (`misfits`). The tolerance is the only option.
"""
