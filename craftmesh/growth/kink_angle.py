"""Kink angles of a crack front, from K or along slip planes, and the force that drives the growth."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.growth.options import CRITERIA, NEAR_FIELD, SLIP, GrowthOptions
from craftmesh.mechanics.near_field import as_tensor, near_field
from craftmesh.mesh.front_frames import FrontFrames
from craftmesh.options import own_code
from craftmesh.surface.measure import span_of
from craftmesh.surface.rounding import SAME_PLACE
from craftmesh.surface.side_data import coordinates_hint, spans_told

# Angles over which the energy release rate is searched, degrees: it peaks at 76 in pure mode II.
WIDEST = 85.0
# Degrees within which the stress is sought: it is largest at 70.5 in pure mode II in isotropic materials.
WIDEST_IN_CRYSTALS = 110.0
STEP = 0.25  # of both searches; a parabola through the best three then finds the angle to 1e-3
# Rows of K among the fields, whose order is that of the axes binormal, normal, tangent.
_ORDER = (1, 0, 2)
# Of the ring's radius: points of the field as near to a place on it count there, one at the place alone.
NEAR = 0.5
# By so much a line may turn back, so that one square to the crack counts both ways; and a plane nearer to
# the one square to the front goes on in every direction.
LEEWAY = np.radians(5)


class Criterion(NamedTuple):
    """Which way a point of a front goes, and what drives it.

    angles: from K_I, K_II, K_III (n, 3) to kink angles (n,) in radians, positive towards the normal, where
    K_I < 0 counts as 0; driving: from K and angles to the driving force (n,), in the unit of K.
    """

    angles: Callable[[np.ndarray], np.ndarray]
    driving: Callable[[np.ndarray, np.ndarray], np.ndarray]


def criterion_of(
    options: GrowthOptions, stiffness: np.ndarray | None = None, ways: np.ndarray | None = None
) -> Criterion:
    """Return the criterion of the options.

    stiffness (n, 6, 6): as in `largest_near_stress`, for criterion near_field; ways (n,): kink angles of
    criterion slip, by `slip_ways`. The driving force of all but near_field is `tangential_intensity`.
    Raises CraftmeshError where one of them is asked for and not given.
    """
    if options.criterion == SLIP:
        if ways is None:
            raise CraftmeshError("grow.criterion is slip, and its angles are not given; see slip_ways")
        return Criterion(lambda _: ways, tangential_intensity)
    if options.criterion != NEAR_FIELD:
        return Criterion(lambda k: kink_angles(k, options.criterion, options.poisson), tangential_intensity)
    if stiffness is None:
        raise CraftmeshError(
            "grow.criterion is near_field, and the crystals are not known; expected their stiffness"
        )
    return Criterion(
        lambda k: largest_near_stress(opened(k), stiffness)[0],
        lambda k, angle: near_stress(k, angle, stiffness),
    )


def opened(k: np.ndarray) -> np.ndarray:
    """Return K (n, 3) with K_I < 0, of a closed crack, as 0."""
    return np.column_stack([np.maximum(k[:, 0], 0.0), k[:, 1:]])


def kink_angles(k: np.ndarray, criterion: str, poisson: float) -> np.ndarray:
    """Return the kink angle (n,) in radians for K_I, K_II, K_III (n, 3), positive towards the normal.

    criterion: tangential_stress (Erdogan & Sih 1963), which solves K_I sin(t) + K_II (3 cos(t) - 1) = 0;
    energy_release, the angle at which a short kink releases most (`energy_release`); or
    package.module:function, which gets (n, 3) and returns (n,) radians. Others need more than K. A closed
    crack (K_I < 0) counts as K_I = 0. Raises CraftmeshError for a criterion that is not there or returns
    anything else.
    """
    k = opened(np.asarray(k, float).reshape(-1, 3))
    size = np.abs(k[:, :2]).max(axis=1, keepdims=True, initial=0.0)
    k = np.where(size > 0, k / np.where(size > 0, size, 1.0), 0.0)  # the angle knows no scale
    if criterion == "tangential_stress":
        k1, k2, _ = k.T
        below = k1 + np.sqrt(k1**2 + 8 * k2**2)
        return -2 * np.arctan2(2 * k2, np.where(below > 0, below, 1.0))
    if criterion == "energy_release":
        tried = _angles_within(WIDEST)
        best, _ = _peak(tried, energy_release(k, tried[None], poisson))
        return np.where(size[:, 0] > 0, best, 0.0)
    angles = np.asarray(own_code("criterion", criterion, CRITERIA)(k), float)
    if angles.shape != (len(k),) or not np.isfinite(angles).all():
        raise CraftmeshError(
            f"criterion {criterion} returned an array of shape {angles.shape}; expected {len(k)} "
            "finite angles in radians"
        )
    return angles


def tangential_intensity(k: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the intensity (n,) of the tangential stress at `angle` (n,) for K (n, 3) (Erdogan & Sih)."""
    half = np.cos(angle / 2)
    return half * (k[:, 0] * half**2 - 1.5 * k[:, 1] * np.sin(angle))


def _angles_within(widest: float) -> np.ndarray:
    """Return angles (a,) in radians every STEP degrees."""
    return np.radians(np.arange(-widest, widest + STEP / 2, STEP))


def _peak(angles: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return where values (n, a) at even angles (a,) are largest, and the value: both (n,)."""
    row, best = np.arange(len(values)), np.clip(np.argmax(values, axis=1), 1, len(angles) - 2)
    before, here, after = (values[row, best + off] for off in (-1, 0, 1))
    bend = before - 2 * here + after
    shift = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1.0), 0.0).clip(-1, 1)
    return angles[best] + shift * (angles[1] - angles[0]), here - 0.25 * (before - after) * shift


def energy_release(k: np.ndarray, angle: np.ndarray, poisson: float) -> np.ndarray:
    """Return E / (1 - nu^2) times the energy release rate (n, m) of kinks at `angle` (n, m) or (1, m).

    The kinks' intensities are those of Amestoy & Leblond (1992); mode III's is exact.
    """
    k1, k2, k3 = (k[:, [mode]] for mode in range(3))
    f11, f12, f21, f22 = kink_factors(angle)
    m = angle / np.pi
    f33 = ((1 - m) / (1 + m)) ** (m / 2)
    opening, sliding, tearing = f11 * k1 + f12 * k2, f21 * k1 + f22 * k2, f33 * k3
    return np.maximum(opening, 0.0) ** 2 + sliding**2 + tearing**2 / (1 - poisson)


def kink_factors(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return F_11, F_12, F_21, F_22 of a short kink: its K_I, K_II over those before (Amestoy & Leblond).

    angle: radians, within +-85 degrees, any shape.
    """
    m, p = np.asarray(angle, float) / np.pi, np.pi
    even, odd = m[..., None] ** np.arange(0, 21, 2), m[..., None] ** np.arange(1, 20, 2)
    f11 = [1, -3 * p**2 / 8, p**2 - 5 * p**4 / 128, p**2 / 9 - 11 * p**4 / 72 + 119 * p**6 / 15360]
    f11 += [5.07790, -2.88312, -0.0925, 2.996, -4.059, 1.63, 4.1]
    f12 = [-3 * p / 2, 10 * p / 3 + p**3 / 16, -2 * p - 133 * p**3 / 180 + 59 * p**5 / 1280]
    f12 += [12.313906, -7.32433, 1.5793, 4.0216, -6.915, 4.21, 4.56]
    f21 = [p / 2, -4 * p / 3 - p**3 / 48, -2 * p / 3 + 13 * p**3 / 30 - 59 * p**5 / 3840]
    f21 += [-6.176023, 4.44112, -1.5340, -2.0700, 4.684, -3.95, -1.32]
    f22 = [1, -4 - 3 * p**2 / 8, 8 / 3 + 29 * p**2 / 18 - 5 * p**4 / 128]
    f22 += [-32 / 15 - 4 * p**2 / 9 - 1159 * p**4 / 7200 + 119 * p**6 / 15360]
    f22 += [10.58254, -4.78511, -1.8804, 7.280, -7.591, 0.25, 12.5]
    return even @ np.array(f11), odd @ np.array(f12), odd @ np.array(f21), even @ np.array(f22)


def largest_near_stress(k: np.ndarray, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return angles (n,) in radians of the largest tangential stress for K (n, 3), and its intensity (n,).

    K_I, K_II, K_III; stiffness (n, 6, 6) over 11, 22, 33, 12, 13, 23 in the axes binormal, normal, tangent.
    The intensity is that stress times root(2 pi r), K_I in pure opening straight ahead. Angle 0 without K.
    """
    angles, stress = tangential_stress(np.asarray(k, float), stiffness)
    fine = _angles_within(WIDEST_IN_CRYSTALS)
    angle, pull = _peak(fine, scipy.interpolate.CubicSpline(angles, stress, axis=1)(fine))
    return np.where(np.abs(k).max(axis=1) > 0, angle, 0.0), pull


def near_stress(k: np.ndarray, angle: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Return the intensity (n,) at `angle` (n,) of the stress that `largest_near_stress` seeks."""
    angles, stress = tangential_stress(np.asarray(k, float), stiffness)
    return np.array([scipy.interpolate.CubicSpline(angles, own)(at) for own, at in zip(stress, angle)])


def tangential_stress(k: np.ndarray, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return angles (a,) and the tangential stress times root(2 pi r) there (n, a), for K (n, 3)."""
    field = near_field(stiffness)
    step = field.angles[1] - field.angles[0]
    chosen = np.abs(field.angles) < np.radians(WIDEST_IN_CRYSTALS) + step
    angles = field.angles[chosen]
    gradient = np.einsum("nm,namij->naij", k[:, list(_ORDER)], field.value[:, chosen, :3])
    stress = np.einsum("nijkl,nakl->naij", as_tensor(stiffness)[..., :2], gradient, optimize=True)
    across = np.stack([-np.sin(angles), np.cos(angles), 0 * angles], axis=1)
    return angles, np.sqrt(2 * np.pi) * np.einsum("ai,naij,aj->na", across, stress, across, optimize=True)


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
    tree = scipy.spatial.cKDTree(field.points)
    for node, plane, sense in np.argwhere(goes):
        turn, radius = angle[node, plane, sense], ring * frames.size[node]
        way = np.cos(turn) * frames.binormal[node] + np.sin(turn) * frames.normal[node]
        place = frames.points[node] + radius * way
        near = np.array(tree.query_ball_point(place, NEAR * radius, return_sorted=True), int)
        if not len(near):
            spans = span_of(field.points), span_of(frames.points)
            at = ", ".join(f"{x:.4g}" for x in place)
            raise CraftmeshError(
                f"{field.source}: has no point within {NEAR * radius:.4g} of ({at}), on the ring round the "
                f"front: {spans_told(('they go', 'the front'), *spans)}{coordinates_hint(*spans)}; give "
                "the slip of this increment there, or another ring (grow.ring)"
            )
        off = np.linalg.norm(field.points[near] - place, axis=1)
        weight = 1 / np.maximum(off, SAME_PLACE * radius)
        slip[node, plane, sense] = np.average(field.activity[near, plane], weights=weight)
    candidates, slipped = angle.reshape(len(slip), -1), slip.reshape(len(slip), -1)
    row, best = np.arange(len(slip)), slipped.argmax(axis=1)
    return np.where(slipped[row, best] > 0, candidates[row, best], 0.0)


def _length(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths (..., 1) of vectors (..., 3)."""
    return np.linalg.norm(vectors, axis=-1, keepdims=True)
