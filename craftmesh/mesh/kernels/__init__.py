"""Numba kernels on tetrahedra."""
