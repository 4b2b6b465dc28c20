"""The largest tangential stress round the front of a crack in a crystal."""

import numpy as np
from scipy.interpolate import CubicSpline

from craftmesh.mechanics.near_field import as_tensor, near_field

# Degrees within which the stress is sought: it is largest at 70.5 in pure mode II in isotropic materials.
WIDEST = 110.0
STEP = 0.25  # of the search; a parabola through the best three then finds the angle to 1e-3
# Rows of K among the fields, whose order is that of the axes binormal, normal, tangent.
_ORDER = (1, 0, 2)


def largest_near_stress(k: np.ndarray, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return angles (n,) in radians of the largest tangential stress for K (n, 3), and its intensity (n,).

    K_I, K_II, K_III; stiffness (n, 6, 6) over 11, 22, 33, 12, 13, 23 in the axes binormal, normal, tangent.
    The intensity is that stress times root(2 pi r), K_I in pure opening straight ahead. Angle 0 without K.
    """
    angles, stress = tangential_stress(np.asarray(k, float), stiffness)
    fine = np.radians(np.arange(-WIDEST, WIDEST + STEP / 2, STEP))
    pull = CubicSpline(angles, stress, axis=1)(fine)
    row, best = np.arange(len(k)), np.clip(np.argmax(pull, axis=1), 1, len(fine) - 2)
    before, here, after = (pull[row, best + off] for off in (-1, 0, 1))
    bend = before - 2 * here + after
    shift = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1.0), 0.0).clip(-1, 1)
    angle = np.where(np.abs(k).max(axis=1) > 0, fine[best] + shift * np.radians(STEP), 0.0)
    return angle, here - 0.25 * (before - after) * shift


def near_stress(k: np.ndarray, angle: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Return the intensity (n,) at `angle` (n,) of the stress that `largest_near_stress` seeks."""
    angles, stress = tangential_stress(np.asarray(k, float), stiffness)
    return np.array([CubicSpline(angles, own)(at) for own, at in zip(stress, angle)])


def tangential_stress(k: np.ndarray, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return angles (a,) and the tangential stress times root(2 pi r) there (n, a), for K (n, 3)."""
    field = near_field(stiffness)
    step = field.angles[1] - field.angles[0]
    chosen = np.abs(field.angles) < np.radians(WIDEST) + step
    angles = field.angles[chosen]
    gradient = np.einsum("nm,namij->naij", k[:, list(_ORDER)], field.value[:, chosen, :3])
    stress = np.einsum("nijkl,nakl->naij", as_tensor(stiffness)[..., :2], gradient, optimize=True)
    across = np.stack([-np.sin(angles), np.cos(angles), 0 * angles], axis=1)
    return angles, np.sqrt(2 * np.pi) * np.einsum("ai,naij,aj->na", across, stress, across, optimize=True)
