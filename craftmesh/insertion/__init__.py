"""The crack's way into a conformal surface.

In come a surface, a crack and lengths; out comes the surface with facets of kind CRACK, and a report
(`insert`). Each part of the crack is a function over its plane (`sheet`) with a boundary (`rim`), and
comes in by five steps: points near it move onto it (`snap`); edges that cross it are split (`cut`), and so
are traces that leave it (`traces`); traces are split at its front, and points move onto that (`pierce`);
the front gets its edges (`front_chain`); front and traces are filled with triangles, which get the grains
they lie in (`crack_patch`). Moves keep to the bounds of `surface/guarded_move`. How far the
result is off the given crack is measured, and where that is too far the crack is tried again with smaller
facets (`attempts`). A crack that consists of facets is named alone (`inlay`). Numbers stand at the heads
of the modules, in shares of the least length; `options` has the user's.
"""
