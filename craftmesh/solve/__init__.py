"""The displacement field of a model: the built-in solver, and checks of fields from other programs.

`solve_model` takes an `ElasticModel` and returns displacements and their residual. `problem` puts the model
into arrays; `kernels` has its elements, its matrix and the sweeps. `iteration` runs conjugate gradients
with a preconditioner of several levels (`levels`). Where lips (crack faces) press on each other, `contact`
finds the pairs of opposite lip nodes whose gap is closed. `foreign` checks fields of other programs against
the model. `options` has the tolerance and the limits.
"""
