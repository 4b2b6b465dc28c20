"""The driving force at each point of a front, in the unit of K; Delta K is its range over a load cycle."""

from collections.abc import Callable

import numpy as np

from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.kink_angle import (
    ORDER,
    in_crystals,
    near_field_of,
    near_stress,
    own_values,
    tangential_intensity,
)
from craftmesh.growth.options import DRIVING, NEAR_FIELD, STRESS, GrowthOptions

# K_Ic / K_IIc and K_Ic / K_IIIc in Richard's comparative K (Richard, Fulland & Sander 2005).
SLIDING, TEARING = 1.155, 1.0


def driving_force(front: FrontPoints, angle: np.ndarray, options: GrowthOptions) -> np.ndarray:
    """Return the driving force (n,) of front points at their K and kink angles (n,), by options.driving.

    A negative K_I counts as it is; the caller sets it to 0 where crack faces are closed (`opened`). Raise
    CraftmeshError if a user-supplied function cannot be found or returns anything but n finite numbers, or
    if the stiffness of a crystal is needed and not known.
    """
    if options.driving == STRESS:
        if options.criterion == NEAR_FIELD:
            return near_stress(front.k, angle, in_crystals(front))
        return tangential_intensity(front.k, angle)
    if options.driving in _BY_K:
        return _BY_K[options.driving](front.k, options.poisson)
    if options.driving == "energy_release":
        return release_intensity(front.k, front.stiffness, options.poisson)
    return own_values("driving", options.driving, DRIVING, len(front.k), front, angle)


def release_intensity(k: np.ndarray, stiffness: np.ndarray, poisson: float) -> np.ndarray:
    """Return the K_I (n,) that alone would have the energy release rate of K (n, 3), all modes together.

    The crack extends straight ahead. stiffness (n, 6, 6): over 11, 22, 33, 12, 13, 23 in the axes binormal,
    normal, tangent; where it is NaN, the material is isotropic with `poisson` as its ratio.
    """
    weight = np.tile(np.diag([1.0, 1.0, 1 / (1 - poisson)]), (len(k), 1, 1))
    known = np.isfinite(stiffness).all(axis=(1, 2))
    if known.any():
        weight[known] = near_field_of(stiffness[known].tobytes()).opening
    along = k[:, list(ORDER)]
    return np.sqrt(np.einsum("ni,nij,nj->n", along, weight, along) / weight[:, 1, 1])


def richard(k: np.ndarray) -> np.ndarray:
    """Return Richard's comparative K (n,) of K (n, 3) (Richard, Fulland & Sander 2005)."""
    shear = (SLIDING * k[:, 1]) ** 2 + (TEARING * k[:, 2]) ** 2
    return k[:, 0] / 2 + np.sqrt(k[:, 0] ** 2 + 4 * shear) / 2


def tanaka(k: np.ndarray, poisson: float) -> np.ndarray:
    """Return Tanaka's effective K (n,) of K (n, 3), from the fourth powers of the modes (Tanaka 1974)."""
    return (k[:, 0] ** 4 + 8 * k[:, 1] ** 4 + 8 * k[:, 2] ** 4 / (1 - poisson)) ** 0.25


_BY_K: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "K_I": lambda k, _: k[:, 0],
    "richard": lambda k, _: richard(k),
    "tanaka": tanaka,
}
