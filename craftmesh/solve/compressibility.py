"""Materials that change their shape but hardly their volume: what displacements alone cannot solve."""

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.mean_moduli import mean_moduli
from craftmesh.mechanics.model import ElasticModel

# Elements of displacements alone lock: on a penny at 45 degrees, five edges to the radius, K errs by up to
# 1.5 % of the largest with a Poisson's ratio of 0.49, by 14 % with 0.499.
MOST_POISSON = 0.49
# Ratios are known to the rounding of a stiffness and its inverse.
_ROUNDING = 1e-9


def check_compressible(model: ElasticModel) -> None:
    """Raise CraftmeshError for a material that is nearly incompressible, its grain and phase named."""
    ratio = poisson_ratios(model.stiffness())
    worst = int(np.argmax(ratio))
    if ratio[worst] <= MOST_POISSON + _ROUNDING:
        return
    grain = int(model.grains[worst])
    phase = model.phase_of[grain]
    material = model.materials[phase]
    of_phase = "" if phase is None else f"{phase}="
    text = f"{of_phase}{material.kind}:{','.join(map(repr, material.constants))}"
    raise CraftmeshError(
        f"material {text} (grain {grain}): Poisson's ratio {ratio[worst]:.6g} is nearly incompressible; "
        f"the built-in solver takes at most {MOST_POISSON:g}; lower it, or take hybrid elements elsewhere"
    )


def poisson_ratios(stiffness: np.ndarray) -> np.ndarray:
    """Return Poisson's ratios (g,) of stiffnesses (g, 6, 6), of crystals that of their means.

    The bulk modulus is that under even pressure (Reuss), the shear modulus the mean over all directions
    (Voigt).
    """
    mean = mean_moduli(stiffness)
    bulk, shear = mean.reuss_bulk, mean.voigt_shear
    return (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)
