"""Numba kernels of the stitching."""
