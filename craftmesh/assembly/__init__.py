"""One mesh from the grains' tetrahedra, with its crack opened.

`assemble` turns the gradated surface and each grain's tetrahedra into a `TetMesh` with its sets, and a
report. Grains share surface points by number, so nothing is matched by position. `opening` doubles the
nodes of the crack except the front nodes, and `boundary_layers` the nodes of grain boundaries that get
cohesive layers. `open_crack` opens a crack in a mesh of any origin; `foreign_mesh` converts meshes of
meshio for it. There are no options and no tuned numbers. A half face is one face of one tetrahedron,
numbered 4 * tet + face; two half faces with the same corners are the two sides of a face inside the mesh.
"""
