"""Numba kernels of the multi-material marching cubes."""
