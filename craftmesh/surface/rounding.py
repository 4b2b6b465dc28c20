"""What counts as equal: none of these numbers is a choice, each lies far over rounding, far under a mesh.

Coordinates in double precision are known to 1e-16 of the model, in float32 files to 6e-8.
"""

# Of an extent, an edge, an area or a unit vector: a smaller difference is rounding.
ROUNDING = 1e-9
# Of an edge's length: places nearer to each other are one place of a mesh.
SAME_PLACE = 1e-6
# Of an area, or of a segment on which a root is looked for: what rounding alone leaves.
EXACT = 1e-12
# Of the box's diagonal: points this near a plane of the box are on it.
ON_PLANE = 1e-7
