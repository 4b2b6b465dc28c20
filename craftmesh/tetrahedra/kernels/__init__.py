"""Numba kernels on tetrahedra inside the grains."""
