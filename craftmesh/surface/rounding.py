"""Tolerances for equality; none is a choice, each is far above rounding and far below a mesh's lengths.

Coordinates in double precision are known to 1e-16 of the model's size, in float32 files to 6e-8.
"""

# Relative difference, to an extent, edge, area or unit vector, below which values are equal.
ROUNDING = 1e-9
# Distance, in edge lengths, below which two places are one place of a mesh.
SAME_PLACE = 1e-6
# Relative error that rounding alone leaves in an area, an angle's cosine or a place on a segment.
EXACT = 1e-12
# Distance from a box plane, in diagonals of the box, below which a point is on it.
ON_PLANE = 1e-7
