"""Structured boxes whose hexagonal crack is bent to a disc or to a cap of a sphere."""

import numpy as np
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.types import TetMesh


def one_grain(centres):
    return np.ones(len(centres), int)


def disc_crack(rings: int, around: int, height: int, label_of=one_grain) -> TetMesh:
    """A crack of radius 1 in z = 0 with edges of 1 / rings, `around` of them of material beside it."""
    n = 2 * (rings + around)
    crack = plane_crack(2, height, hexagon((n / 2, n / 2), rings))
    mesh, _ = assemble(*structured_box((n, n, 2 * height), label_of, crack))
    p = mesh.points - [n / 2, n / 2, height]
    x, y = p[:, 0] - 0.5 * p[:, 1], np.sqrt(0.75) * p[:, 1]  # the hexagon is a regular one now
    ring = np.maximum(np.maximum(abs(p[:, 0]), abs(p[:, 1])), abs(p[:, 0] - p[:, 1]))
    scale = ring / np.where(ring > 0, np.hypot(x, y), 1)
    return moved(mesh, np.stack([x * scale, y * scale, p[:, 2]], axis=1) / rings)


def cap_crack(rings: int, around: int, height: int, tilt: float) -> TetMesh:
    """The disc bent to a cap of the sphere round the origin: its rim is tilted by `tilt` radians."""
    mesh = disc_crack(rings, around, height)
    x, y, z = mesh.points.T
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    radius = 1 / tilt  # of the sphere; the arc from its pole to the rim is 1
    out = (radius + z) * np.sin(r * tilt)
    return moved(
        mesh, np.stack([out * np.cos(angle), out * np.sin(angle), (radius + z) * np.cos(r * tilt)], axis=1)
    )


def moved(mesh: TetMesh, points: np.ndarray) -> TetMesh:
    return TetMesh(points, mesh.tets, mesh.grain, mesh.node_sets, mesh.face_sets)
