"""Renewal: the part of a mesh that a grown crack changes is cut out, meshed again and put back.

`whole_of_mesh` reads a `TetMesh` with an open crack as tetrahedra on a closed surface (`Whole`). `region`
finds the tetrahedra that the new crack and the new target lengths change. `cut_out` makes a body of its own
of them: faces inside grains are facets of kind BORDER, which no stage changes. The body goes through
insertion, gradation and tetrahedra like any other. `put_back` joins the result and the tetrahedra that
stay, and `numbering` keeps the numbers of nodes and elements that stay. `renew` calls these steps.
"""
