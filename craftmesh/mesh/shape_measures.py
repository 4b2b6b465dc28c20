"""Shape of tetrahedra: volume, aspect ratio, dihedral angles and shape factor."""

from itertools import combinations

import numpy as np

from craftmesh.mesh.integration import parts_of
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, FACE_CORNERS

_OPPOSITE = np.array([[0, 5], [1, 3], [2, 4]])  # edges without a common corner


def shape_measures(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Return (m, 5): volume, aspect ratio, smallest and largest dihedral in degrees, shape factor.

    Aspect ratio: longest edge over smallest altitude; infinite for a flat element. Shape factor:
    volume over that of the regular tetrahedron with the same circumsphere; 0 when flat.
    """
    parts = [_measured(points[tets[rows]]) for rows in parts_of(np.arange(len(tets)))]
    return np.concatenate([np.zeros((0, 5)), *parts])


def _measured(corners: np.ndarray) -> np.ndarray:
    """Return the measures (m, 5) of elements with corners (m, 4, 3)."""
    edges = corners[:, EDGE_CORNERS[:, 1]] - corners[:, EDGE_CORNERS[:, 0]]
    length = np.sqrt((edges * edges).sum(axis=2))
    a, b, c = corners[:, FACE_CORNERS].transpose(2, 0, 1, 3)
    faces = np.cross(b - a, c - a)
    double = np.sqrt((faces * faces).sum(axis=2))
    six_volume = (faces[:, 0] * edges[:, 3]).sum(axis=1)
    size = np.abs(six_volume)
    cosines = np.stack([_cosine(faces, double, i, j) for i, j in combinations(range(4), 2)])
    x, y, z = (length[:, _OPPOSITE[:, 0]] * length[:, _OPPOSITE[:, 1]]).T
    # 24 R V by Crelle's formula, R the circumradius
    crelle = np.sqrt(np.maximum((x + y + z) * (x + y - z) * (x - y + z) * (-x + y + z), 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        aspect = np.where(size > 0, length.max(axis=1) * double.max(axis=1) / size, np.inf)
        factor = size / 6 / (8 * np.sqrt(3.0) / 27 * (crelle / (4 * size)) ** 3)
    angles = np.degrees(np.arccos([cosines.max(axis=0), cosines.min(axis=0)]))
    return np.column_stack([six_volume / 6, aspect, *angles, np.where(size > 0, factor, 0.0)])


def _cosine(faces: np.ndarray, double: np.ndarray, i: int, j: int) -> np.ndarray:
    """Return the cosine (m,) of the dihedral angle between two faces, 1 where one has no area."""
    areas = double[:, i] * double[:, j]
    cosine = -(faces[:, i] * faces[:, j]).sum(axis=1) / np.where(areas > 0, areas, 1.0)
    return np.where(areas > 0, cosine.clip(-1, 1), 1.0)
