"""Queries on the tetrahedral mesh.

`tet_connectivity` gives faces and edges, `mesh_sets` sets by name, `lips` the pairs of nodes on a crack.
The front comes as ordered nodes (`front`), as a smooth curve (`front_curve`, on `cubic_basis`) and with
frames (`front_frames`). `shape_measures` measures elements, `quality` makes the paper's table, `check_tets`
reports broken invariants. `second_order` adds mid nodes, `integration` has rules of integration.
"""
