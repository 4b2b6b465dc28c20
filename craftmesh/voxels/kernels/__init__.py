"""Compiled loops over the voxels."""
