"""Cracks: prescribed and given shapes, and their insertion into a conformal surface."""

from craftmesh.cracking.insert import insert_crack
from craftmesh.cracking.series import check_crack, crack_of_increment
from craftmesh.cracking.shapes import CrackOptions, prescribed_crack
from craftmesh.cracking.triangulated import crack_from_triangles

__all__ = [
    "CrackOptions",
    "check_crack",
    "crack_from_triangles",
    "crack_of_increment",
    "insert_crack",
    "prescribed_crack",
]
