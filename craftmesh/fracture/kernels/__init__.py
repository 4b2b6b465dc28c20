"""Numba kernels on the surroundings of a crack front."""
