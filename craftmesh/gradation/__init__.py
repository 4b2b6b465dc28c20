"""The gradation: local operations that fit a surface's edges to the sizing, each checked by guards.

`gradate` takes a surface and a sizing, and returns the surface with edges of the target lengths and a
report. The surface is prepared (`nonmanifold_vertices`, `preprocess`, `folds`, `locality`) and put into
working arrays (`state`). Rounds of collapse, split, swap and vertex moves follow (`passes`), then the
cleaning (`cleaning`). Each file in `kernels` has one operation, and `kernels/one_pass` tries an operation
at all edges or vertices. Guards, the checks of angles, normals, distances, volumes and intersections, test
each operation before it is made (`kernels/guards`). `kernels/sheets` names facets that need no intersection
test. Refused operations are counted by reason (`kernels/result_codes`). Crack and front stay close to the
given crack (`crack_reference`, `kernels/crack_guard`). `Limits` has the bounds of a pass, which `gradate`
makes from the user's options and its constants. docs/glossary.md explains the terms.
"""
