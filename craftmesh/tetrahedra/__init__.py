"""Tetrahedra in the grains.

The input is the gradated surface and target lengths, the output the tets of each grain on the surface's
points. `volume` has the whole chain and its two halves: the grains, in chunks, and the whole model. A
worker meshes each grain (`tetrahedralize`, `grain_meshing`): a first mesh, the scaffold, separates inside
from outside (`grain_region`), a lattice gives interior points (`interior_points`), a mesher fills the grain
(`meshers`), and a grain that fails gets attempts with fewer demands (`ladder`). `optimise_tets` improves
the tets in the worker by one list of operations (`kernels/tet_operations`) for one objective after another
(`kernels/tet_objective`). Surface points then move within their classification and tolerance
(`surface_freedom`), with all their grains: first along the surface, and last off the surface where tets are
poor (`surface_moves`). If a grain fails every attempt, fTetWild meshes the whole model (`fallback`,
`whole`). The numbers are the schedule of `optimise_tets` and the reaches of `surface_moves`.
"""
