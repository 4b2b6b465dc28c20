"""Insert a crack into a conformal surface.

`insert` takes a surface, a crack and target lengths; it returns the surface with facets of kind CRACK, and
a report. Each part of the crack is a function over its plane (`sheet`) with a boundary (`rim`). It is
inserted in these steps: points near it move onto it (`snap`); edges that cross it are split (`cut`); traces
that leave it are split (`traces`); traces are split at its front, and points move onto the front
(`pierce`); the front gets its edges (`front_chain`); triangles fill front and traces, and get the labels of
their grains (`crack_patch`). Moves keep the bounds of `surface/guarded_move`. The distance of the result
from the given crack is measured; if it is too large, the crack is inserted again with smaller facets
(`attempts`). A crack that consists of facets of the surface is only marked (`intergranular_crack`).
Constants stand at the top of the modules, in smallest target lengths; `options` has the user's values.
"""
