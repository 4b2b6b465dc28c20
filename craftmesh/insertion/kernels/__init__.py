"""Numba kernels of plane triangulations."""
