"""One conformal surface from the surfaces of the grains.

In comes a closed surface for each grain, out comes one surface with both sides of each facet (`stitch`).
Equal points become one, and those within the tolerance; facets of two grains
with the same corners become one. Facets of one grain alone are those of the box, of the outside or of
voids (`outer_shells`), and the planes of the box are made exact. Grains that do not match, intersect or
lie apart are refused with their ids, the place and what to do (`misfits`). The tolerance is the only
option.
"""
