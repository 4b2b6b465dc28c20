"""One mesh from the grains' tetrahedra, its crack opened.

In come the gradated surface and each grain's tetrahedra, out come a `TetMesh` with its sets and a report
(`assemble`). Points of the surface are shared by number, so that nothing is matched by place. `opening`
doubles the nodes of the crack, but for its fronts, and `boundary_layers` those of grain boundaries that
get cohesive layers. `open_crack` does the same in a mesh of any maker, which `foreign_mesh` reads through
meshio. There are no options and no tuned numbers.
"""
