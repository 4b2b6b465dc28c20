"""Numba kernels for drawing pictures."""
