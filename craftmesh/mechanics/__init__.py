"""Materials and orientations of the grains."""
