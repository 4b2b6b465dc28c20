"""Growth along slip planes (stage I): the plane that slips most before the front gives the direction."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.front_frames import FrontFrames

# Of the ring's radius: points of the field as near to a place on it count there.
NEAR = 0.5
NEAREST = 1e-6  # and a point nearer than that counts alone
# By so much a line may turn back, so that one square to the crack counts both ways; and a plane nearer to
# the one square to the front goes on in every direction.
LEEWAY = np.radians(5)


@dataclass(frozen=True, eq=False)
class SlipField:
    """Slip of planes at points (k, 3): normals (p, 3) in the crystal's axes, activity (k, p).

    activity: accumulated slip, or any fatigue indicator that grows with it, of each plane.
    """

    points: np.ndarray
    normals: np.ndarray
    activity: np.ndarray
    source: str = "slip_table"


def slip_ways(frames: FrontFrames, turns: np.ndarray, field: SlipField, ring: float) -> np.ndarray:
    """Return kink angles (n,) in radians along the slip plane that is most active ahead of each front node.

    A plane meets the plane normal to the front in a line, forwards within 90 degrees; its activity is that
    of the field where this line leaves a ring round the node, `ring` local edges in radius. turns
    (n, 3, 3): active rotations from crystal to sample axes at the nodes. 0 where nothing slips. Raises
    CraftmeshError where the field has no point near such a place.
    """
    normals = np.einsum("nij,pj->npi", turns, field.normals / _length(field.normals))
    lines = np.cross(normals, frames.tangent[:, None])
    ahead, up = (np.einsum("npi,ni->np", lines, axis) for axis in (frames.binormal, frames.normal))
    angle = np.arctan2(up, ahead)
    angle = np.stack([angle, angle - np.copysign(np.pi, angle)], axis=2)
    goes = (np.abs(angle) <= np.pi / 2 + LEEWAY) & (_length(lines) >= np.sin(LEEWAY))
    slip = np.zeros(angle.shape)
    tree = cKDTree(field.points)
    for node, plane, sense in np.argwhere(goes):
        turn, radius = angle[node, plane, sense], ring * frames.size[node]
        way = np.cos(turn) * frames.binormal[node] + np.sin(turn) * frames.normal[node]
        place = frames.points[node] + radius * way
        near = np.array(tree.query_ball_point(place, NEAR * radius, return_sorted=True), int)
        if not len(near):
            at = ", ".join(f"{x:.4g}" for x in place)
            raise CraftmeshError(
                f"{field.source}: has no point within {NEAR * radius:.4g} of ({at}), on the ring round the "
                "front; give the slip of this increment there, or another ring (grow.ring)"
            )
        off = np.linalg.norm(field.points[near] - place, axis=1)
        weight = 1 / np.maximum(off, NEAREST * radius)
        slip[node, plane, sense] = np.average(field.activity[near, plane], weights=weight)
    candidates, slipped = angle.reshape(len(slip), -1), slip.reshape(len(slip), -1)
    row, best = np.arange(len(slip)), slipped.argmax(axis=1)
    return np.where(slipped[row, best] > 0, candidates[row, best], 0.0)


def _length(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths (..., 1) of vectors (..., 3)."""
    return np.linalg.norm(vectors, axis=-1, keepdims=True)
