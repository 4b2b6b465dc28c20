"""Numba kernels on triangles."""
