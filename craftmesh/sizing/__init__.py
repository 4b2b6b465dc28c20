"""Target edge lengths, which grow with the distance from cracks and voids (Eq. 2-3 of the gradation paper).

`sources` collects the defects around which edges are refined - fronts, voids, points - and returns a
`Sizing` (`sizing`). All stages ask its `at(points)`, which returns the smallest of all its lengths.
`clearance` adds shorter lengths where a crack comes near to a face or to another of its surfaces.
`length_field` holds lengths at points, from a file, from the curvature or from a surface's own edges, and
limits how they grow. `stored` converts a sizing to arrays and back. Constants stand at the top of
`clearance` and `sizing`.
"""

from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for

__all__ = ["Sizing", "SizingOptions", "densify", "sizing_for"]
