"""Eigenstrains: strains that grains would have if nothing held them, from heat, transformation or work."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.materials import COLUMN, COMPONENT, ROW, numbers_by_phase

_COUNT = {"isotropic": 1, "orthotropic": 3, "anisotropic": 6}
_EXPECTED = (
    "expected KIND:VALUES or PHASE=KIND:VALUES: isotropic and one value, orthotropic and three (11, 22, "
    "33), or anisotropic and six (11, 22, 33, 12, 13, 23)"
)


def parse_eigenstrains(texts: Iterable[str]) -> dict[int | None, np.ndarray]:
    """Return strains (3, 3) by phase from texts such as "isotropic:1e-3" or "2=orthotropic:1e-3,1e-3,0".

    A text without a phase applies to all phases (key None). Raises CraftmeshError for texts of another
    form and for components over 1 in magnitude.
    """
    found = {}
    for key, (kind, values) in numbers_by_phase("eigenstrain", texts, _EXPECTED).items():
        numbers = np.array(values)
        if len(numbers) != _COUNT.get(kind):
            raise CraftmeshError(f"eigenstrain: {kind} with {len(numbers)} values; {_EXPECTED}")
        if not np.abs(numbers).max() <= 1:
            raise CraftmeshError(
                f"eigenstrain: {max(values, key=abs):g} is not within -1 to 1; give small strains "
                "such as 0.001: the coefficient of thermal expansion times the change of temperature"
            )
        found[key] = as_strain(numbers)
    return found


def as_strain(numbers: np.ndarray) -> np.ndarray:
    """Return a strain (3, 3) from 1 component (isotropic), 3 (11, 22, 33) or 6 (11, 22, 33, 12, 13, 23).

    Shears are tensor components, half the engineering shears.
    """
    if len(numbers) < 6:
        return np.diag(np.broadcast_to(numbers, 3)) + 0.0
    return numbers[COMPONENT]


def components(strain: np.ndarray) -> np.ndarray:
    """Return components (g, 6) of strains (g, 3, 3): 11, 22, 33, and the engineering shears 12, 13, 23."""
    return strain[:, ROW, COLUMN] * np.where(ROW == COLUMN, 1.0, 2.0)


def eigenstrains_of_grains(
    texts: Sequence[str], grains: np.ndarray, phases: np.ndarray | None, axes: Mapping[int, np.ndarray]
) -> np.ndarray:
    """Return the eigenstrain (g, 3, 3) of each of the grains (g,) in its own axes; 0 if its phase has none.

    texts: such as "2=isotropic:1e-3" (`parse_eigenstrains`); phases (n,): row = grain id; axes: crystal
    axes (6,) by grain of known orientation. Raises CraftmeshError if strains are given by phase but phases
    are unknown or no grain has them, and if a grain without orientation gets a strain that is not
    isotropic.
    """
    given = parse_eigenstrains(texts)
    if given and phases is None and None not in given:
        raise CraftmeshError("eigenstrain: given by phase, but grains have no phase; give one for all")
    found = np.zeros((len(grains), 3, 3))
    own = [int(phases[grain]) if phases is not None and grain < len(phases) else 0 for grain in grains]
    if given and None not in given and not set(given) & set(own):
        raise CraftmeshError(
            f"eigenstrain: no grain has phase {', '.join(map(str, given))}; expected one of "
            f"{', '.join(map(str, sorted(set(own))))}"
        )
    for row, (grain, phase) in enumerate(zip(grains.tolist(), own)):
        found[row] = given.get(phase, given.get(None, 0.0))
        if grain not in axes and not is_even(found[row]):
            raise CraftmeshError(
                f"eigenstrain: grain {grain} has no orientation, which its strain needs; give "
                "orientations with the microstructure, or an isotropic strain"
            )
    return found


def given_strains(
    given: Mapping[int, np.ndarray], grains: np.ndarray, axes: Mapping[int, np.ndarray]
) -> np.ndarray:
    """Return strains (g, 3, 3) of grains (g,), each in its grain's axes.

    given: the strain (3, 3) of every grain by id, in sample axes; axes: crystal axes (6,) by grain.
    """
    found = []
    for grain in grains.tolist():
        turn, strain = axes_of(grain, axes), given[grain]
        found.append(strain if is_even(strain) else turn.T @ strain @ turn)
    return np.array(found).reshape(-1, 3, 3)


def axes_of(grain: int, axes: Mapping[int, np.ndarray]) -> np.ndarray:
    """Return the crystal axes of a grain as columns (3, 3); the sample's axes if `axes` lacks the grain.

    axes: by grain, the sample components (6,) of the crystal's first and second axis.
    """
    if grain not in axes:
        return np.eye(3)
    first, second = axes[grain].reshape(2, 3)
    return np.column_stack([first, second, np.cross(first, second)])


def is_even(strain: np.ndarray) -> bool:
    """Return whether a strain (3, 3) is isotropic: equal along all axes, without shear."""
    return bool((strain == strain[0, 0] * np.eye(3)).all())
