"""Kink angles along slip planes: the most active plane ahead of each front node, from a table of slip."""

from dataclasses import dataclass

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.growth.options import ACCUMULATED, ENERGY, GrowthOptions
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mesh.front_curve import unit
from craftmesh.mesh.front_frames import FrontFrames
from craftmesh.surface.measure import span_of
from craftmesh.surface.rounding import ROUNDING, SAME_PLACE
from craftmesh.surface.side_data import coordinates_hint, spans_told

# Radius, relative to that of the ring around a front node on which slip is read, around a point of the
# ring. Points of the user's slip table within it are averaged, weighted by inverse distance.
NEAR = 0.5
# Tolerance of two angles, in radians. A slip line may point backwards by it, so that a line perpendicular
# to the crack counts in both senses. A slip plane whose angle to the plane normal to the front is less has
# no clear line in that plane, and is skipped.
LEEWAY = np.radians(5)


@dataclass(frozen=True, eq=False)
class SlipField:
    """Slip of s systems, or of s planes, at points (k, 3), from a table of the user.

    normals (s, 3): plane normals in crystal axes, of any length. slip (k, s): slip of each, or any fatigue
    indicator that grows with it. grain (k,): grain of each point, None if unknown. directions (s, 3): slip
    directions in crystal axes, None for planes. stress (k, 6): components 11, 22, 33, 12, 13, 23 in sample
    axes, None if unknown. source: name of the table in error messages.
    """

    points: np.ndarray
    normals: np.ndarray
    slip: np.ndarray
    grain: np.ndarray | None = None
    directions: np.ndarray | None = None
    stress: np.ndarray | None = None
    source: str = "slip_table"


def slip_kink_angles(
    frames: FrontFrames,
    turns: np.ndarray,
    field: SlipField,
    options: GrowthOptions,
    grain: np.ndarray | None = None,
) -> np.ndarray:
    """Return kink angles (n,) in radians along the slip plane that is most active ahead of each front node.

    A slip plane meets the plane normal to the front in a line, of which the part that points forwards
    counts. The plane's activity is the mean of `plane_activity` near the point where this line crosses a
    ring around the node, with a radius of options.ring local edges; the plane with the largest is the most
    active. The angle is 0 where no plane slips. turns (n, 3, 3): active rotations from crystal to sample
    axes at the nodes. grain (n,): grains of the nodes; if the field's points have grains, a node reads
    points of its grain only, and planes whose line has left the grain at the ring do not count. Raise
    CraftmeshError if the field has no point of any grain near a crossing, or lacks data that
    options.slip_parameter needs.
    """
    _check_columns(field, options)
    axes = unit(field.normals)
    plane_of = (np.abs(axes @ axes.T) > 1 - ROUNDING).argmax(axis=1)  # the first system of the plane
    planes = np.unique(plane_of)
    systems = [np.flatnonzero(plane_of == first) for first in planes]
    normals = np.einsum("nij,pj->npi", turns, axes[planes])
    lines = np.cross(normals, frames.tangent[:, None])
    ahead, up = (np.einsum("npi,ni->np", lines, axis) for axis in (frames.binormal, frames.normal))
    angle = np.arctan2(up, ahead)
    angle = np.stack([angle, angle - np.copysign(np.pi, angle)], axis=2)
    is_clear = np.linalg.norm(lines, axis=2, keepdims=True) >= np.sin(LEEWAY)
    activity = np.zeros(angle.shape)
    tree, of_points = scipy.spatial.cKDTree(field.points), None if grain is None else field.grain
    for node, plane, sense in np.argwhere((np.abs(angle) <= np.pi / 2 + LEEWAY) & is_clear):
        turn, radius = angle[node, plane, sense], options.ring * frames.size[node]
        way = np.cos(turn) * frames.binormal[node] + np.sin(turn) * frames.normal[node]
        place = frames.points[node] + radius * way
        near = np.array(tree.query_ball_point(place, NEAR * radius, return_sorted=True), int)
        if not len(near):
            spans = span_of(field.points), span_of(frames.points)
            at = ", ".join(f"{x:.4g}" for x in place)
            raise CraftmeshError(
                f"{field.source}: has no point within {NEAR * radius:.4g} of ({at}), on the ring around "
                f"the front: {spans_told(('its points', 'the front'), *spans)}{coordinates_hint(*spans)}; "
                "give the slip of this increment there, or another ring (grow.ring)"
            )
        if grain is not None and of_points is not None:
            near = near[of_points[near] == grain[node]]
            if not len(near):
                continue  # the plane's line has left the grain where it crosses the ring
        weight = 1 / np.maximum(np.linalg.norm(field.points[near] - place, axis=1), SAME_PLACE * radius)
        values = plane_activity(field, near, systems[plane], turns[node], options)
        activity[node, plane, sense] = np.average(values, weights=weight)
    candidates, active = angle.reshape(len(angle), -1), activity.reshape(len(angle), -1)
    row, best = np.arange(len(angle)), active.argmax(axis=1)
    return np.where(active[row, best] > 0, candidates[row, best], 0.0)


def plane_activity(
    field: SlipField, points: np.ndarray, systems: np.ndarray, turn: np.ndarray, options: GrowthOptions
) -> np.ndarray:
    """Return options.slip_parameter (k,) of the plane of `systems` at points (k,) of the field.

    turn (3, 3): active rotation from crystal to sample axes there. The slip of a plane is the sum over its
    systems. Fatemi and Socie's parameter (1988) is the largest of its systems, without unit; compression of
    the plane counts as no normal stress. The energy is the sum over its systems of resolved shear stress
    times slip, in the unit of the stress.
    """
    slip = field.slip[np.ix_(points, systems)]
    if options.slip_parameter == ACCUMULATED or field.stress is None:
        return slip.sum(axis=1)
    normal = turn @ unit(field.normals[systems[0]])
    traction = field.stress[points][:, COMPONENT] @ normal
    if options.slip_parameter == ENERGY and field.directions is not None:
        shear = traction @ turn @ unit(field.directions[systems]).T
        return np.abs(shear * slip).sum(axis=1)
    tension = np.maximum(traction @ normal, 0.0) / (options.cyclic_yield_stress or np.inf)
    return np.abs(slip).max(axis=1) / 2 * (1 + (options.fatemi_socie_k or 0.0) * tension)


def _check_columns(field: SlipField, options: GrowthOptions) -> None:
    """Raise CraftmeshError if the field lacks the stress or the directions that the parameter needs."""
    name, needed = options.slip_parameter, []
    if name != ACCUMULATED and field.stress is None:
        needed.append("the stress sxx, syy, szz, sxy, sxz, syz")
    if name == ENERGY and field.directions is None:
        needed.append("slip_hkl_uvw of each system, such as slip_111_0-11")
    if needed:
        raise CraftmeshError(
            f"{field.source}: has no columns of {' and '.join(needed)}; grow.slip_parameter {name} needs "
            "them, add them, or use slip_parameter: slip"
        )
