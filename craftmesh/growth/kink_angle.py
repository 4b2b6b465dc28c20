"""Kink angles of a crack front, from K."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.options import CRITERIA, NEAR_FIELD, SLIP, STRESS, WIDEST_IN_CRYSTALS, GrowthOptions
from craftmesh.mechanics.near_field import NearField, as_tensor, near_field
from craftmesh.options import import_user_callable, returned_array

# Degrees: largest kink angle tried for the energy release rate, which in pure mode II peaks at 76.
WIDEST = 85.0
STEP = 0.25  # degrees between tried angles; a parabola through the best three finds the angle to 1e-3
# Columns of K in the order of the near fields, whose modes displace along binormal, normal and tangent:
# K_II, K_I, K_III.
ORDER = (1, 0, 2)


def kink_angles_of(front: FrontPoints, options: GrowthOptions) -> np.ndarray:
    """Return the kink angle (n,) of front points in radians, by options.criterion.

    K_I < 0 counts as 0, except in user-supplied functions. The angle of the largest tangential stress is 0
    where the intensity of this stress is not above the doubt (estimated error) of K, as under K_III alone,
    because the angle would then only follow the noise of K_I and K_II. Raise CraftmeshError if the
    criterion needs stiffness or slip angles that the points lack, and if a user-supplied function is not
    found or returns anything but n finite numbers.
    """
    if options.criterion == SLIP:
        if np.isnan(front.slip_angle).any():
            raise CraftmeshError("grow.criterion is slip, but slip_angle is NaN; pass angles of slip_ways")
        return front.slip_angle
    if options.criterion == NEAR_FIELD:
        angle, pull = largest_near_stress(opened(front.k), in_crystals(front))
        return np.where(pull > front.doubt, angle, 0.0)
    if options.criterion not in CRITERIA:
        return own_values("criterion", options.criterion, CRITERIA, len(front.k), front)
    angle = kink_angles(front.k, options.criterion, options.poisson)
    known = tangential_intensity(opened(front.k), angle) > front.doubt
    return np.where(known | (options.criterion != STRESS), angle, 0.0)


def in_crystals(front: FrontPoints) -> np.ndarray:
    """Return the stiffness (n, 6, 6) of the crystals at the front points.

    Raise CraftmeshError if it is unknown or has NaN.
    """
    if np.isnan(front.stiffness).any():
        raise CraftmeshError("grow.criterion is near_field, but a stiffness is NaN; pass it for all points")
    return front.stiffness


def own_values(key: str, name: str, known: Sequence[str], count: int, *given: object) -> np.ndarray:
    """Return the `count` finite numbers that the user's function `name` returns for the arguments `given`.

    key: the option that names the function; known: built-in values of this option. Raise CraftmeshError if
    the function cannot be found or returns anything else; the function's own exceptions pass.
    """
    found = import_user_callable(key, name, known)(*given)
    values = returned_array(f"{key} {name}", found, f"{count} finite numbers")
    if values.shape != (count,) or not np.isfinite(values).all():
        raise CraftmeshError(
            f"{key} {name} returned an invalid array of shape {values.shape}; expected {count} finite "
            "numbers, one per row of K"
        )
    return values


def opened(k: np.ndarray) -> np.ndarray:
    """Return K (n, 3) with negative K_I, which means a closed crack, set to 0."""
    return np.column_stack([np.maximum(k[:, 0], 0.0), k[:, 1:]])


def kink_angles(k: np.ndarray, criterion: str, poisson: float) -> np.ndarray:
    """Return the kink angle (n,) in radians for K_I, K_II, K_III (n, 3), positive towards the normal.

    criterion: tangential_stress (Erdogan & Sih 1963), which solves K_I sin(t) + K_II (3 cos(t) - 1) = 0;
    richard (Richard, Fulland & Sander 2005); straight, with angle 0; or energy_release, the angle at which
    a short kink has the largest energy release rate (`energy_release`). A closed crack (K_I < 0) counts as
    K_I = 0. The angle is 0 where K_I and K_II are 0.
    """
    k = opened(np.asarray(k, float).reshape(-1, 3))
    if criterion == "richard":
        total = np.abs(k).sum(axis=1)
        share = np.abs(k[:, 1]) / np.where(total > 0, total, 1.0)
        return -np.sign(k[:, 1]) * np.radians(140.0 * share - 70.0 * share**2)
    if criterion == "straight":
        return np.zeros(len(k))
    size = np.abs(k[:, :2]).max(axis=1, keepdims=True, initial=0.0)
    k = np.where(size > 0, k / np.where(size > 0, size, 1.0), 0.0)  # the angle depends only on ratios of K
    if criterion == STRESS:
        k1, k2, _ = k.T
        below = k1 + np.sqrt(k1**2 + 8 * k2**2)
        return -2 * np.arctan2(2 * k2, np.where(below > 0, below, 1.0))
    tried = _angles_within(WIDEST)
    best, _ = _peak(tried, energy_release(k, tried[None], poisson))
    return np.where(size[:, 0] > 0, best, 0.0)


def tangential_intensity(k: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the tangential stress times sqrt(2 pi r) (n,) at `angle` (n,) for K (n, 3) (Erdogan & Sih)."""
    half = np.cos(angle / 2)
    return half * (k[:, 0] * half**2 - 1.5 * k[:, 1] * np.sin(angle))


def _angles_within(widest: float) -> np.ndarray:
    """Return angles (a,) in radians from -widest to widest degrees, every STEP degrees."""
    return np.radians(np.arange(-widest, widest + STEP / 2, STEP))


def _peak(angles: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the angles (n,) at which rows of values (n, a) peak, and the peak values (n,).

    angles (a,): evenly spaced. A parabola through the largest value and its neighbours gives the peak.
    """
    row, best = np.arange(len(values)), np.clip(np.argmax(values, axis=1), 1, len(angles) - 2)
    before, here, after = (values[row, best + off] for off in (-1, 0, 1))
    bend = before - 2 * here + after
    shift = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1.0), 0.0).clip(-1, 1)
    return angles[best] + shift * (angles[1] - angles[0]), here - 0.25 * (before - after) * shift


def energy_release(k: np.ndarray, angle: np.ndarray, poisson: float) -> np.ndarray:
    """Return E / (1 - nu^2) times the energy release rate (n, m) of short kinks at angles (n, m) or (1, m).

    k (n, 3): K before the kink. K_I and K_II at the end of the kink follow Amestoy & Leblond (1992), K_III
    is exact. A negative K_I there counts as 0.
    """
    k1, k2, k3 = (k[:, [mode]] for mode in range(3))
    f11, f12, f21, f22 = kink_factors(angle)
    m = angle / np.pi
    f33 = ((1 - m) / (1 + m)) ** (m / 2)
    opening, sliding, tearing = f11 * k1 + f12 * k2, f21 * k1 + f22 * k2, f33 * k3
    return np.maximum(opening, 0.0) ** 2 + sliding**2 + tearing**2 / (1 - poisson)


def kink_factors(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the factors F_11, F_12, F_21, F_22 of a short kink at `angle` (Amestoy & Leblond 1992).

    The kink's K_I is F_11 K_I + F_12 K_II and its K_II is F_21 K_I + F_22 K_II, with K before the kink.
    angle: radians, any shape; the series hold within +-85 degrees (not checked).
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

    The intensity is the stress times sqrt(2 pi r), so it is K_I straight ahead in pure mode I. Angles up to
    WIDEST_IN_CRYSTALS are searched; the angle is 0 if K is 0. stiffness (n, 6, 6): over 11, 22, 33, 12, 13,
    23 in the axes binormal, normal, tangent.
    """
    angles, stress = tangential_stress(np.asarray(k, float), stiffness)
    fine = _angles_within(WIDEST_IN_CRYSTALS)
    angle, pull = _peak(fine, scipy.interpolate.CubicSpline(angles, stress, axis=1)(fine))
    return np.where(np.abs(k).max(axis=1) > 0, angle, 0.0), pull


def near_stress(k: np.ndarray, angle: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Return the tangential stress times sqrt(2 pi r) (n,) near the front, at `angle` (n,) from its plane.

    k (n, 3): K_I, K_II, K_III; stiffness (n, 6, 6), in axes as in `largest_near_stress`.
    """
    angles, stress = tangential_stress(np.asarray(k, float), stiffness)
    return np.array([scipy.interpolate.CubicSpline(angles, own)(at) for own, at in zip(stress, angle)])


@lru_cache(maxsize=1)  # each end of each load cycle asks for the fields of the same points
def near_field_of(stiffness: bytes) -> NearField:
    """Return the fields near the front in crystals, from the bytes of their stiffness (k, 6, 6).

    The bytes are the key of the cache; only the last result is kept.
    """
    return near_field(np.frombuffer(stiffness).reshape(-1, 6, 6))


def tangential_stress(k: np.ndarray, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return angles (a,) in radians and the tangential stress times sqrt(2 pi r) (n, a), for K (n, 3).

    The stiffness (n, 6, 6) is in axes as in `largest_near_stress`.
    """
    field = near_field_of(stiffness.tobytes())
    step = field.angles[1] - field.angles[0]
    chosen = np.abs(field.angles) < np.radians(WIDEST_IN_CRYSTALS) + step
    angles = field.angles[chosen]
    gradient = np.einsum("nm,namij->naij", k[:, list(ORDER)], field.value[:, chosen, :3])
    stress = np.einsum("nijkl,nakl->naij", as_tensor(stiffness)[..., :2], gradient, optimize=True)
    across = np.stack([-np.sin(angles), np.cos(angles), 0 * angles], axis=1)
    return angles, np.sqrt(2 * np.pi) * np.einsum("ai,naij,aj->na", across, stress, across, optimize=True)
