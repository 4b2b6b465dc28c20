"""Renewal: the part of a mesh that a grown crack changes is cut out, meshed again and put back.

`whole_of_mesh` reads a `TetMesh`, in which the crack faces are separate, as tetrahedra on a surface whose
crack is one layer of facets (`Whole`). `region` finds the tetrahedra that the new crack and the new target
lengths change. `cut_out` makes a separate body of these: the faces inside grains where it was cut out
become facets of kind BORDER, which no stage changes. The body goes through
insertion, gradation and tetrahedra like any other. `put_back` joins the result and the tetrahedra that
stay, and `numbering` keeps the numbers of nodes and elements that stay. `renew` calls these steps.
"""
