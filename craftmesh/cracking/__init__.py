"""Cracks: prescribed and given shapes, and their insertion into a conformal surface."""
