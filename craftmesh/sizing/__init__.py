"""The wished edge lengths, Eq. 2-3.

`sources` gathers what edges are refined around - fronts, voids, points - and gives a `Sizing` (`sizing`),
whose `at(points)` all stages ask. The least of all its lengths counts. `clearance` adds shorter ones
where a crack comes near to a face or to another of its sheets. `length_field` holds lengths at points,
from a file, from the curvature or from a surface's own edges, and bounds how they grow. `stored` turns a
sizing into arrays and back; numbers stand at the heads of `clearance` and `sizing`.
"""

from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for

__all__ = ["Sizing", "SizingOptions", "densify", "sizing_for"]
