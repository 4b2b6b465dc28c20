"""Points of integration in 10-node tetrahedra and on their faces."""

from typing import NamedTuple

import numpy as np

from craftmesh.fracture.kernels.forces import Rule
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, FACE_CORNERS

# Walkington's rule of 14 points, degree 5: (barycentric coordinate that repeats, weight) of the points on
# the lines to the corners, and of those on the lines between the middles of opposite edges.
_TO_CORNERS = (
    (0.31088591926330060980, 0.11268792571801585080),
    (0.09273525031089122640, 0.07349304311636194954),
)
_BETWEEN_EDGES = (0.04550370412564964949, 0.04254602077708146644)
# Radon's rule of 7 points on a triangle, degree 5: likewise, and the centre's weight.
_TRIANGLE = ((0.47014206410511505, 0.13239415278850616), (0.10128650732345633, 0.12593918054482717))
_CENTRE_WEIGHT = 0.225
# Each side of a free face is cut into as many parts: fields vary as the root of the distance to the front.
_PARTS = 3
_CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


class FaceRules(NamedTuple):
    """Points on the four faces: value (4, p, 10), slope (4, p, 10, 3), weight (p,), outward (4, 3)."""

    rule: Rule
    outward: np.ndarray


def element_rule() -> Rule:
    """Return the 14 points in a tetrahedron; weights add up to 1 / 6."""
    points, weights = [], []
    for repeated, weight in _TO_CORNERS:
        for corner in range(4):
            barycentric = np.full(4, repeated)
            barycentric[corner] = 1 - 3 * repeated
            points.append(barycentric[1:])
            weights.append(weight)
    small, edge_weight = _BETWEEN_EDGES
    for ends in EDGE_CORNERS:
        barycentric = np.full(4, small)
        barycentric[ends] = 0.5 - small
        points.append(barycentric[1:])
        weights.append(edge_weight)
    return _rule(np.array(points), np.array(weights) / 6)


def face_rules() -> FaceRules:
    """Return the points on the four faces; weights add up to 1 / 2, outward is twice the area's vector."""
    flat, weight = triangle_points()
    rules, outward = [], []
    for corners in FACE_CORNERS:
        a, b, c = _CORNERS[corners]
        rules.append(_rule(a + flat[:, :1] * (b - a) + flat[:, 1:] * (c - a), weight))
        outward.append(-np.cross(b - a, c - a))  # by the right-hand rule they point inwards
    value, slope = (np.stack([rule[k] for rule in rules]) for k in (0, 1))
    return FaceRules(Rule(value, slope, weight), np.array(outward))


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


def _rule(points: np.ndarray, weights: np.ndarray) -> Rule:
    """Return shape functions at points (p, 3), the coordinates of corners 2, 3, 4."""
    first = 1 - points.sum(axis=1, keepdims=True)
    share = np.hstack([first, points])
    share_slope = np.vstack([-np.ones(3), np.eye(3)])
    a, b = EDGE_CORNERS.T
    value = np.hstack([share * (2 * share - 1), 4 * share[:, a] * share[:, b]])
    corner_slope = (4 * share - 1)[:, :, None] * share_slope
    edge_slope = 4 * (share[:, a, None] * share_slope[b] + share[:, b, None] * share_slope[a])
    return Rule(value, np.concatenate([corner_slope, edge_slope], axis=1), weights)
