"""Tetrahedra in the grains.

In come the gradated surface and lengths, out come the tets of each grain on the surface's own points.
`volume` has the whole chain and its two halves: the grains, which chunks share, and the whole model.
Each grain is meshed in a worker (`tetrahedralize`, `grain_meshing`): a first mesh tells inside from
outside (`grain_region`), a lattice gives points (`interior_points`), a mesher fills the grain
(`meshers`), and a grain that fails is tried with less asked (`ladder`). `optimise_tets` betters the tets
inside by one list of operations (`kernels/tet_operations`) for one objective after another
(`kernels/tet_objective`). Then, in all grains at once, the surface gives way where tets are at fault
(`flat_places`, `opening_model`, `surface_freedom`), and its points slide (`whole_optimisation`). Where a
grain fails every attempt, fTetWild meshes the whole model (`fallback`, `whole`). The numbers are the
schedule of `optimise_tets` and the stages of `opening_model`.
"""
