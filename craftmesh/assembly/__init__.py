"""One mesh from the grains' tetrahedra, with its crack opened.

`assemble` turns the gradated surface and each grain's tetrahedra into a `TetMesh` with its sets, and a
report. Grains share surface points by number, so nothing is matched by position. `opening` doubles the
nodes of the crack except the front nodes, and `boundary_layers` the nodes of grain boundaries that get
cohesive layers. `open_crack` opens a crack in a mesh of any origin, which `foreign_mesh` reads through
meshio. There are no options and no tuned numbers.
"""
