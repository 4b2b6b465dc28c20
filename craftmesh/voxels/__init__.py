"""Labelled volumes as they are read and cleaned, and the orientations of their grains."""
