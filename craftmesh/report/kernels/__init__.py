"""Numba kernels of the pictures."""
