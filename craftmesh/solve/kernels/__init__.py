"""Compiled loops over elements and blocks of the stiffness matrix."""
