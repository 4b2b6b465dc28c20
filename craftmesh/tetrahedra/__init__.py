"""Tetrahedra in the grains."""
