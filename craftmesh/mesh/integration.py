"""Rules of integration over tetrahedra and their faces, and shape functions."""

from collections.abc import Iterator
from itertools import permutations
from typing import NamedTuple

import numpy as np

from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, FACE_CORNERS

# Barycentric coordinates of the four integration points of C3D10 in Abaqus and CalculiX: _NEAR at each
# corner in turn, _FAR at the others.
_NEAR, _FAR = (5 + 3 * np.sqrt(5)) / 20, (5 - np.sqrt(5)) / 20
# Rules by their number of points. A rule consists of orbits, the points that permutations of barycentric
# coordinates give; per orbit, its first point and each point's fraction of the volume. 1 and 4 points,
# exact to degree 1 and 2, are those of C3D4 and C3D10 (Hammer & Stroud 1956); 14, exact to degree 5, are
# Walkington's (2000).
_A, _B, _C = 0.3108859192633006, 0.0927352503108912, 0.0455037041256496
_ORBITS = {
    1: (((0.25, 0.25, 0.25, 0.25), 1.0),),
    4: (((_NEAR, _FAR, _FAR, _FAR), 0.25),),
    14: (
        ((1 - 3 * _A, _A, _A, _A), 0.1126879257180159),
        ((1 - 3 * _B, _B, _B, _B), 0.0734930431163619),
        ((0.5 - _C, 0.5 - _C, _C, _C), 0.0425460207770815),
    ),
}
_CORNER_SLOPES = np.concatenate([-np.ones((1, 3)), np.eye(3)])
# Number of points in C3D10: 4 as in Abaqus and CalculiX; with 14, K_I is 0.4 % larger and less noisy, and
# elements with quarter points carry uniform strain exactly.
DECK_RULE, FULL_RULE = 4, 14
# Radon's rule of 7 points on a triangle, exact to degree 5: for each orbit of three points, the barycentric
# coordinate that occurs twice, and the weight; then the weight of the centre.
_TRIANGLE, _CENTRE_WEIGHT = (
    ((0.47014206410511505, 0.13239415278850616), (0.10128650732345633, 0.12593918054482717)),
    0.225,
)
_PARTS = 3  # subdivisions of each side of a face, because fields vary as the root of the front's distance
AT_ONCE = 10_000  # elements that are processed at once: arrays of some 10 MB


def tet_rule(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the rule of 1, 4 or 14 points: barycentric coordinates (q, 4) and weights (q,) of sum 1/6."""
    places, weights = [], []
    for first, share in _ORBITS[points]:
        orbit = sorted(set(permutations(first)), reverse=True)
        places += orbit
        weights += [share / 6] * len(orbit)
    return np.array(places), np.array(weights)


def shape_slopes(places: np.ndarray, width: int) -> np.ndarray:
    """Return the slopes (q, width, 3) of shape functions of 4 or 10 nodes at barycentric places (q, 4).

    Slopes are derivatives by the coordinates of the corners 2, 3 and 4; mid nodes are in Abaqus' order.
    """
    if width == 4:
        return np.repeat(_CORNER_SLOPES[None], len(places), axis=0)
    a, b = EDGE_CORNERS.T
    corners = (4 * places - 1)[:, :, None] * _CORNER_SLOPES
    middles = 4 * (places[:, a, None] * _CORNER_SLOPES[b] + places[:, b, None] * _CORNER_SLOPES[a])
    return np.concatenate([corners, middles], axis=1)


def shape_values(places: np.ndarray, width: int = 10) -> np.ndarray:
    """Return the values (q, width) of shape functions of 4 or 10 nodes at barycentric places (q, 4)."""
    if width == 4:
        return places
    a, b = EDGE_CORNERS.T
    return np.hstack([places * (2 * places - 1), 4 * places[:, a] * places[:, b]])


class FaceRules(NamedTuple):
    """Integration points on the four faces of a 10-node element.

    value (4, p, 10), slope (4, p, 10, 3): shape functions there; weight (p,); outward (4, 3): normals in
    the element's own coordinates; share (p, 3): barycentric coordinates on the face.
    """

    value: np.ndarray
    slope: np.ndarray
    weight: np.ndarray
    outward: np.ndarray
    share: np.ndarray


def face_rules() -> FaceRules:
    """Return points on the four faces; weights add up to 1 / 2, outward is twice the face's area vector."""
    flat, weight = triangle_points()
    on_face = np.column_stack([1 - flat.sum(axis=1), flat])
    share = np.zeros((4, len(flat), 4))
    np.put_along_axis(share, FACE_CORNERS[:, None], on_face[None], axis=2)
    value, slope = shape_values(share.reshape(-1, 4)), shape_slopes(share.reshape(-1, 4), 10)
    a, b, c = np.eye(4)[:, 1:][FACE_CORNERS].swapaxes(0, 1)
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


def jacobians(points: np.ndarray, tets: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Return the derivatives (m, q, 3, 3) of position in elements (m, k) by the element's own coordinates.

    slopes (q, k, 3), or (m, q, k, 3): from `shape_slopes`. Row i of a matrix belongs to the spatial
    coordinate i, column j to the element's coordinate j.
    """
    corners = points[tets] - points[tets[:, :1]]  # slopes add up to 0, so any point may be the origin
    return corners[:, None].swapaxes(2, 3) @ slopes


def determinants(jacobian: np.ndarray) -> np.ndarray:
    """Return the determinants (...) of matrices (..., 3, 3)."""
    return (np.cross(jacobian[..., 0, :], jacobian[..., 1, :]) * jacobian[..., 2, :]).sum(axis=-1)


def parts_of(rows: np.ndarray, size: int = AT_ONCE) -> Iterator[np.ndarray]:
    """Yield rows (k,) in parts of at most `size`."""
    return (rows[first : first + size] for first in range(0, len(rows), size))


def smallest_jacobians(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Return the least Jacobian determinant (m,) over the points at which solvers integrate an element.

    tets (m, 4) or (m, 10) in Abaqus' order. For an element with straight edges and mid nodes in their
    middles it is six times the volume at every point.
    """
    if tets.shape[1] == 4:  # its Jacobian is the same everywhere
        parts = (points[tets[rows, 1:]] - points[tets[rows, :1]] for rows in parts_of(np.arange(len(tets))))
        return np.concatenate([np.zeros(0), *(determinants(part.swapaxes(1, 2)) for part in parts)])
    slopes = shape_slopes(tet_rule(4)[0], tets.shape[1])
    parts = (determinants(jacobians(points, tets[rows], slopes)) for rows in parts_of(np.arange(len(tets))))
    return np.concatenate([np.zeros(0), *(part.min(axis=1) for part in parts)])


class FacePoints(NamedTuple):
    """Points on faces (f,): value (q, k) of the nodes' shape functions there, place (f, q, 3).

    area (f, q, 3): outward normals times the part of the area that each point represents.
    """

    value: np.ndarray
    place: np.ndarray
    area: np.ndarray


def face_points(nodes: np.ndarray, rule: tuple[np.ndarray, np.ndarray] | None = None) -> FacePoints:
    """Return integration points on faces whose nodes have the coordinates `nodes` (f, 3 or 6, 3).

    rule: points (q, 2) and weights (q,) in the unit triangle; by default those of `triangle_points`.
    """
    points, weights = rule or triangle_points()
    areas = np.column_stack([1 - points.sum(axis=1), points])
    turns = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    value, slope = areas, np.broadcast_to(turns, (len(points), 3, 2))
    if nodes.shape[1] == 6:
        ahead = [1, 2, 0]
        value = np.hstack([areas * (2 * areas - 1), 4 * areas * areas[:, ahead]])
        middles = 4 * (areas[:, ahead, None] * turns + areas[:, :, None] * turns[ahead])
        slope = np.concatenate([(4 * areas - 1)[:, :, None] * turns, middles], axis=1)
    u, v = (slope[:, :, k] @ nodes for k in range(2))
    # minus, because the order of FACE_CORNERS gives inward normals
    return FacePoints(value, value @ nodes, -weights[:, None] * np.cross(u, v))


def corner_shares(corners: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return barycentric coordinates (f, q, 3) of places (f, q, 3) in flat faces with corners (f, 3, 3).

    On a face with a quarter point they differ from the arguments of its shape functions.
    """
    sides = corners[:, 1:] - corners[:, :1]
    shares = (places - corners[:, :1]) @ np.linalg.pinv(sides)
    return np.concatenate([1 - shares.sum(axis=2, keepdims=True), shares], axis=2)
