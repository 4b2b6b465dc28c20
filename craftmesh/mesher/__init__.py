"""Replaceable tetrahedral meshers behind one small interface."""
