"""Linear elastic materials: isotropic, cubic, hexagonal or with all 21 constants."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError

_COUNT = {"isotropic": 2, "cubic": 3, "hexagonal": 5, "anisotropic": 21}
_NAMES = {"isotropic": "E, nu", "cubic": "c11, c12, c44", "hexagonal": "c11, c12, c13, c33, c44"}
_NAMES |= {"anisotropic": "D1111, D1122, D2222, ... D2323"}
# Row and column in a tensor of each component of stress and strain, in the order 11, 22, 33, 12, 13, 23 of
# all stiffnesses; COMPONENT: the component number of each entry.
ROW, COLUMN = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]]).T
COMPONENT = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])
# Factors from engineering strains to tensor strains, and from a compliance to tensor components: shears are
# halved.
_OF_SHEAR = np.where(ROW == COLUMN, 1.0, 0.5)
_OF_TENSOR = np.outer(_OF_SHEAR, _OF_SHEAR)
# (row, column) of the 21 constants, column by column of the upper triangle: D1111, D1122, D2222, ...
_UPPER = tuple((row, column) for column in range(6) for row in range(column + 1))


@dataclass(frozen=True)
class Material:
    """A linear elastic material in its own axes; stresses in the model's unit.

    kind and constants: "isotropic" (E, nu); "cubic" (c11, c12, c44); "hexagonal" (c11, c12, c13, c33, c44),
    the c axis along the crystal's z, as in Bunge angles, DREAM.3D and DAMASK; "anisotropic" the 21
    constants D1111, D1122, D2222, D1133, D2233, D3333, D1112, ... D2323 in the order of Abaqus and
    CalculiX, with engineering shear strains. Raises CraftmeshError for an unknown kind, a wrong count, or
    constants that do not give a positive strain energy for every strain.
    """

    kind: str
    constants: tuple[float, ...]

    def __post_init__(self) -> None:
        if self.kind not in _COUNT:
            raise CraftmeshError(f"material {self.kind!r} is unknown; expected one of {', '.join(_COUNT)}")
        constants = tuple(float(value) for value in self.constants)
        object.__setattr__(self, "constants", constants)
        if len(constants) != _COUNT[self.kind]:
            raise CraftmeshError(
                f"{self.kind} material has {len(constants)} constants; expected {_COUNT[self.kind]}: "
                f"{_NAMES[self.kind]}"
            )
        stable = np.isfinite(constants).all() and (self.kind != "isotropic" or -1 < constants[1] < 0.5)
        if not stable or np.linalg.eigvalsh(self.stiffness()).min() <= 0:
            raise CraftmeshError(
                f"{self.kind} material {', '.join(map(repr, constants))} has no positive strain energy for "
                "every strain; check the constants and their order"
            )

    def stiffness(self) -> np.ndarray:
        """Return the stiffness (6, 6) in order 11, 22, 33, 12, 13, 23, with engineering shear strains."""
        stiffness = np.zeros((6, 6))
        if self.kind == "anisotropic":
            for value, (row, column) in zip(self.constants, _UPPER):
                stiffness[row, column] = stiffness[column, row] = value
            return stiffness
        if self.kind == "hexagonal":
            c11, c12, c13, c33, c44 = self.constants
            c66 = (c11 - c12) / 2
        else:
            c11, c12, c44 = self.constants if self.kind == "cubic" else _lame(*self.constants)
            c13, c33, c66 = c12, c11, c44
        stiffness[:3, :3] = [[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]]
        np.fill_diagonal(stiffness[3:, 3:], [c66, c44, c44])
        return stiffness

    def in_axes(self, matrix: np.ndarray) -> "Material":
        """Return the material described in other axes, the columns of `matrix` (3, 3).

        The columns are components in the material's own axes. An isotropic material is returned unchanged.
        """
        if self.kind == "isotropic":
            return self
        stiffness = turned(self.stiffness(), matrix.T)
        return Material("anisotropic", tuple(float(stiffness[place]) for place in _UPPER))

    def upper_triangle(self) -> list[float]:
        """Return the 21 constants in the order of kind "anisotropic"."""
        stiffness = self.stiffness()
        return [float(stiffness[place]) for place in _UPPER]


def _lame(young: float, poisson: float) -> tuple[float, float, float]:
    """Return c11, c12 and c44 of an isotropic material."""
    shear = young / (2 * (1 + poisson))
    c12 = 2 * shear * poisson / (1 - 2 * poisson)
    return c12 + 2 * shear, c12, shear


def turned(stiffness: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Return stiffnesses (..., 6, 6) of crystals, rotated from crystal axes to sample axes.

    matrix (..., 3, 3): the active rotations from crystal to sample axes; rows are the sample's axes in
    crystal components. Source: W. L. Bond, Bell Syst. Tech. J. 22 (1943), the matrix of stresses.
    """
    on_row, on_column = matrix[..., ROW, :], matrix[..., COLUMN, :]
    straight = on_row[..., ROW] * on_column[..., COLUMN]
    crossed = on_row[..., COLUMN] * on_column[..., ROW]
    bond = straight + np.where(ROW != COLUMN, crossed, 0.0)
    return bond @ stiffness @ bond.swapaxes(-1, -2)


class MeanModuli(NamedTuple):
    """Mean bulk and shear moduli (g,): Voigt's for uniform strain, Reuss's for uniform stress."""

    voigt_bulk: np.ndarray
    voigt_shear: np.ndarray
    reuss_bulk: np.ndarray
    reuss_shear: np.ndarray

    @property
    def anisotropy(self) -> np.ndarray:
        """Universal anisotropy index (g,) of Ranganathan & Ostoja-Starzewski (2008), 0 if isotropic."""
        index = 5 * self.voigt_shear / self.reuss_shear + self.voigt_bulk / self.reuss_bulk - 6
        return np.maximum(index, 0.0)


def mean_moduli(stiffness: np.ndarray) -> MeanModuli:
    """Return the mean moduli of stiffnesses (g, 6, 6), whose last three components are shears."""
    compliance = _means(np.linalg.inv(stiffness) * _OF_TENSOR)
    return MeanModuli(*_means(stiffness), 1 / (9 * compliance[0]), 1 / (4 * compliance[1]))


def _means(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bulk and shear averages (g,) of matrices (g, 6, 6) in tensor components."""
    stretch = np.trace(matrix[:, :3, :3], axis1=1, axis2=2)
    across = matrix[:, :3, :3].sum(axis=(1, 2)) - stretch
    shear = np.trace(matrix[:, 3:, 3:], axis1=1, axis2=2)
    return (stretch + across) / 9, (2 * stretch - across + 6 * shear) / 30


def parse_materials(texts: Iterable[str]) -> dict[int | None, Material]:
    """Return materials by phase from texts such as "cubic:108e3,61e3,28e3" or "2=isotropic:200e3,0.3".

    A text without a phase applies to all phases (key None). Raises CraftmeshError for texts of another
    form, unstable constants, and no text at all.
    """
    expected = "expected KIND:CONSTANTS or PHASE=KIND:CONSTANTS as cubic:8e3,6e3,2e3"
    found = numbers_by_phase("material", texts, expected)
    if not found:
        raise CraftmeshError("material: no material; give one for all phases, or one per phase")
    return {phase: Material(kind, tuple(numbers)) for phase, (kind, numbers) in found.items()}


def numbers_by_phase(
    option: str, texts: Iterable[str], expected: str
) -> dict[int | None, tuple[str, list[float]]]:
    """Return (kind, numbers) by phase, None for all, from texts KIND:NUMBERS or PHASE=KIND:NUMBERS.

    option, expected: the option's key and the expected form, for errors. Raises CraftmeshError for texts of
    another form, for two texts of one phase, and for texts both with and without a phase.
    """
    found: dict[int | None, tuple[str, list[float]]] = {}
    for text in texts:
        head, _, numbers = text.partition(":")
        phase, named, kind = head.rpartition("=")
        try:
            key = int(phase) if named else None
            values = [float(number) for number in numbers.split(",")]
        except ValueError:
            raise CraftmeshError(f"{option}: {text!r}; {expected}") from None
        if key is not None and key < 0:
            raise CraftmeshError(f"{option}: {text!r}; {expected}")
        if key in found:
            raise CraftmeshError(f"{option}: {text!r} is the second entry for its phase; keep one")
        found[key] = kind.strip(), values
    if None in found and len(found) > 1:
        raise CraftmeshError(f"{option}: one entry has no phase; give one for all phases, or one per phase")
    return found


def phases_of_grains(
    grains: np.ndarray,
    materials: Mapping[int | None, object],
    phases: np.ndarray | None,
    option: str = "material",
) -> dict[int, int | None]:
    """Return the key in `materials` of each of the grains (g,), by grain id.

    phases (n,), row = grain id, 0 unknown; option: the key that errors name. Raises CraftmeshError for a
    phase without a material, and for several materials without phases.
    """
    if None in materials:
        return dict.fromkeys(grains.tolist(), None)
    if phases is None:
        if len(materials) == 1:
            return dict.fromkeys(grains.tolist(), next(iter(materials)))
        raise CraftmeshError(
            f"{option}: {len(materials)} entries by phase, but grains have no phase; give one for all"
        )
    found: dict[int, int | None] = {
        grain: int(phases[grain]) if grain < len(phases) else 0 for grain in grains.tolist()
    }
    for grain, phase in found.items():
        if phase not in materials:
            raise CraftmeshError(f"{option}: grain {grain} has phase {phase}, which no entry has; add one")
    return found
