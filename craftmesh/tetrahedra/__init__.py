"""Tetrahedra in the grains.

The input is the gradated surface and target lengths, the output the tets of each grain on the surface's
points. `volume` has the whole chain and its two halves: filling the grains, in chunks, and completing the
whole model. A worker process meshes each grain (`tetrahedralize`, `grain_meshing`): a first mesh, the
scaffold, separates inside from outside (`grain_region`), a lattice gives interior points
(`interior_points`), and a mesher fills the grain (`meshers`). A grain that fails gets further attempts with
fewer demands on the mesh (`meshing_attempts`). `optimise_tets` improves the tets in the worker by one list
of operations (`kernels/tet_operations`) for one objective after another (`kernels/tet_objective`). Surface
points then move within the bounds of `surface_freedom`, for all grains at once: first along the surface,
and last off the surface where tets are faulty (`surface_moves`). If a grain fails every attempt, fTetWild
meshes the whole model (`fallback`, `whole`). The schedule of operations is in `optimise_tets`, and the
largest moves are in `surface_moves` and `surface_freedom`.
"""
