"""Numba kernels of the gradation, with one file per operation."""
