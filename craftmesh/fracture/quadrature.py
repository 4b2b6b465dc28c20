"""Points of integration in 10-node tetrahedra and on their faces."""

from typing import NamedTuple

import numpy as np

from craftmesh.mesh.integration import shape_slopes, shape_values, tet_rule
from craftmesh.mesh.tet_connectivity import FACE_CORNERS

# In elements; 4 points give K_I 0.4 % less, and more noise.
POINTS = 14
# Radon's rule of 7 points on a triangle, degree 5: likewise, and the centre's weight.
_TRIANGLE = ((0.47014206410511505, 0.13239415278850616), (0.10128650732345633, 0.12593918054482717))
_CENTRE_WEIGHT = 0.225
# Each side of a free face is cut into as many parts: fields vary as the root of the distance to the front.
_PARTS = 3
_CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


class Rule(NamedTuple):
    """Points of integration: values (p, 10) and slopes (p, 10, 3) of the shape functions, weights (p,)."""

    value: np.ndarray
    slope: np.ndarray
    weight: np.ndarray


class FaceRules(NamedTuple):
    """Points on the four faces: value (4, p, 10), slope (4, p, 10, 3), weight (p,), outward (4, 3).

    share (p, 3): barycentric coordinates by the face's corners.
    """

    value: np.ndarray
    slope: np.ndarray
    weight: np.ndarray
    outward: np.ndarray
    share: np.ndarray


def element_rule() -> Rule:
    """Return the 14 points in a tetrahedron; weights add up to 1 / 6."""
    share, weight = tet_rule(POINTS)
    return Rule(shape_values(share), shape_slopes(share, 10), weight)


def face_rules() -> FaceRules:
    """Return the points on the four faces; weights add up to 1 / 2, outward is twice the area's vector."""
    flat, weight = triangle_points()
    on_face = np.column_stack([1 - flat.sum(axis=1), flat])
    share = np.zeros((4, len(flat), 4))
    np.put_along_axis(share, FACE_CORNERS[:, None], on_face[None], axis=2)
    value, slope = shape_values(share.reshape(-1, 4)), shape_slopes(share.reshape(-1, 4), 10)
    a, b, c = _CORNERS[FACE_CORNERS].swapaxes(0, 1)
    outward = -np.cross(b - a, c - a)  # by the right-hand rule they point inwards
    shape = 4, len(flat), 10
    return FaceRules(value.reshape(shape), slope.reshape(*shape, 3), weight, outward, on_face)


def triangle_points() -> tuple[np.ndarray, np.ndarray]:
    """Return points (p, 2) and weights (p,) in the unit triangle, cut into nine parts of 7 points."""
    third = np.full((1, 3), 1 / 3)
    points, weights = [third], [np.array([_CENTRE_WEIGHT])]
    for repeated, weight in _TRIANGLE:
        points.append(np.full((3, 3), repeated) + (1 - 3 * repeated) * np.eye(3))
        weights.append(np.full(3, weight))
    once, share = np.concatenate(points)[:, 1:], np.concatenate(weights) / 2
    parts = [
        ((once if upright else 1 - once) + (i, j)) / _PARTS
        for i in range(_PARTS)
        for j in range(_PARTS - i)
        for upright in ((True, False) if i + j < _PARTS - 1 else (True,))
    ]
    return np.concatenate(parts), np.tile(share / _PARTS**2, len(parts))
