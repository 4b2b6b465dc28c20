"""The crack's way into a conformal surface.

In come a surface, a crack and lengths; out comes the surface with facets of kind CRACK, and a report
(`insert`). Each part of the crack is a function over its plane (`sheet`) with a boundary (`rim`), and
comes in by five steps: points near it move onto it (`snap`); edges that cross it are split (`cut`,
`traces`); traces are split at its front, and points move onto that (`pierce`, `onto_front`,
`front_chords`); front and traces are filled with triangles (`front_chain`, `crack_patch`, `patch`,
`bends`); these get the grains they lie in (`regions`). Moves keep to the bounds of
`surface/guarded_move`. How far the result is off the given crack is measured (`misfit`), and where that
is too far the crack is tried again with smaller facets (`attempts`). Numbers stand at the heads of the
modules, in shares of the least length; `options` has the user's.
"""
