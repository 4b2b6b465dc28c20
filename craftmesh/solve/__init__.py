"""The field of displacements of a model: the built-in solver, and fields that other programs found."""
