"""Meshers of single grains, replaceable."""
