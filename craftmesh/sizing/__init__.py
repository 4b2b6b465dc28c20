"""The wished edge lengths, Eq. 2-3."""

from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for

__all__ = ["Sizing", "SizingOptions", "densify", "sizing_for"]
