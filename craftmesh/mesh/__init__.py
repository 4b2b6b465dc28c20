"""The tetrahedral mesh: what can be asked of it."""
