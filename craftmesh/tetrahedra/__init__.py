"""Tetrahedra in the grains.

In come the gradated surface and lengths, out come the tets of each grain on the surface's own points.
`volume` has the whole chain and its two halves: the grains, which chunks share, and the whole model.
Each grain is meshed in a worker (`tetrahedralize`, `grain_meshing`): a first mesh tells inside from
outside (`grain_region`), a lattice gives points (`interior_points`), a mesher fills the grain
(`meshers`), and a grain that fails is tried with less asked (`ladder`). `optimise_tets` improves the tets
by one list of operations (`kernels/tet_operations`) for one objective after another
(`kernels/tet_objective`), once and in the worker. A point of the surface then moves within its
classification and its tolerance (`surface_freedom`), for all grains at it alike: it slides, and last it
leaves the surface where tets are at fault (`surface_moves`). Where a grain
fails every attempt, fTetWild meshes the whole model (`fallback`, `whole`). The numbers are the
schedule of `optimise_tets` and the reaches of `surface_moves`.
"""
