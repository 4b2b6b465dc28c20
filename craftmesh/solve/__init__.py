"""The field of displacements of a model: the built-in solver, and fields that other programs found.

In comes an `ElasticModel`, out come displacements and how far they are from balance (`solve_model`).
`problem` puts the model into arrays; `kernels` has its elements, its matrix and the sweeps. `iteration`
takes conjugate gradients with two levels (`levels`), and where lips press on each other `contact` finds
which pairs of nodes are closed. `foreign` holds fields from elsewhere against the model. `options` has the
tolerance and the bounds.
"""
