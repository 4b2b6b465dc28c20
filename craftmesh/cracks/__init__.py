"""Cracks: prescribed and given shapes, one increment after another."""
