"""The gradation: a surface's edges fitted to the sizing, step by step, each step behind the same guards.

In come a surface and a sizing, out come the surface with edges of those lengths and a report (`gradate`).
The surface is prepared (`tied_nodes`, `preprocess`, `folds`, `locality`) and put into working arrays
(`state`); rounds of collapse, split, swap and slide follow (`passes`), then the cleaning (`cleaning`). One
file in `kernels` holds one operation, and `kernels/one_pass` tries it at all edges or vertices; each is
checked by all guards before it is made (`kernels/guards`), but not against what it cannot meet
(`kernels/sheets`), and refusals are counted by reason (`kernels/codes`). Crack and front are held to the
given ones (`crack_reference`, `kernels/crack_guard`).
The bounds of a pass are its `Limits`, which `gradate` makes of the user's options and of the numbers at
its head; the words are in the glossary of docs/architecture.md.
"""
