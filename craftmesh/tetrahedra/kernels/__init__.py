"""Numba kernels on tetrahedra inside the grains.

The star of a point is the set of tets with this corner. The ring of an edge is the cycle of tets around it.
A cavity is a set of tets that an operation replaces by others with the same outer faces. A cone is the set
of tets that join one point, the apex, to given faces. A face is positive with a point if the tet of face
and point has a positive volume. An aim (`tet_objective`) is what the changes of a pass must improve.
"""
