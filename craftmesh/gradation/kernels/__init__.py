"""Numba kernels of the gradation: one operation, one file."""
