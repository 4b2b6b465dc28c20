"""Linear elastic materials: isotropic, cubic, hexagonal or with all 21 constants."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError

_COUNT = {"isotropic": 2, "cubic": 3, "hexagonal": 5, "anisotropic": 21}
_NAMES = {"isotropic": "E, nu", "cubic": "c11, c12, c44", "hexagonal": "c11, c12, c13, c33, c44"}
_NAMES |= {"anisotropic": "D1111, D1122, D2222, ... D2323"}
# Components of stress and strain in the order of all stiffnesses: 11, 22, 33, 12, 13, 23.
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
# Column by column of the upper triangle over them: D1111, D1122, D2222, D1133, ...
_UPPER = tuple((row, column) for column in range(6) for row in range(column + 1))


@dataclass(frozen=True)
class Material:
    """A linear elastic material in its own axes; stresses in the model's unit.

    kind and constants: "isotropic" (E, nu); "cubic" (c11, c12, c44); "hexagonal" (c11, c12, c13, c33, c44),
    the c axis along the crystal's z, as Bunge angles, DREAM.3D and DAMASK have it; "anisotropic" the 21
    constants D1111, D1122, D2222, D1133, D2233, D3333, D1112, ... D2323 as Abaqus and CalculiX order them,
    with engineering shear strains. Raises CraftmeshError for another kind, a wrong count, or constants that
    do not give a positive strain energy for every strain.
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
        """Return the (6, 6) stiffness over 11, 22, 33, 12, 13, 23 with engineering shear strains."""
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
        """Return the material in other axes: columns of matrix (3, 3), unit vectors in its own."""
        if self.kind == "isotropic":
            return self
        stiffness = turned(self.stiffness(), matrix.T)
        return Material("anisotropic", tuple(float(stiffness[place]) for place in _UPPER))

    def upper_triangle(self) -> list[float]:
        """Return the 21 constants in the order of `anisotropic`."""
        stiffness = self.stiffness()
        return [float(stiffness[place]) for place in _UPPER]


def _lame(young: float, poisson: float) -> tuple[float, float, float]:
    """Return c11, c12 and c44 of an isotropic material."""
    shear = young / (2 * (1 + poisson))
    c12 = 2 * shear * poisson / (1 - 2 * poisson)
    return c12 + 2 * shear, c12, shear


def turned(stiffness: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Return the stiffness (6, 6) of a crystal in the axes of the sample.

    matrix (3, 3): the active rotation from crystal to sample axes.
    Source: W. L. Bond, Bell Syst. Tech. J. 22 (1943), the matrix of stresses.
    """
    row, column = np.array(_PLACES).T
    straight = matrix[row][:, row] * matrix[column][:, column]
    crossed = matrix[row][:, column] * matrix[column][:, row]
    bond = straight + np.where(row != column, crossed, 0.0)
    return bond @ stiffness @ bond.T


def parse_materials(texts: Iterable[str]) -> dict[int | None, Material]:
    """Return materials by phase from texts such as "cubic:108e3,61e3,28e3" or "2=isotropic:200e3,0.3".

    A text without a phase holds for every phase (key None). Raises CraftmeshError for other texts.
    """
    materials: dict[int | None, Material] = {}
    for text in texts:
        head, found, constants = text.partition(":")
        phase, named, kind = head.rpartition("=")
        try:
            key = int(phase) if named else None
            found = found if key is None or key >= 0 else ""
            values = tuple(float(value) for value in constants.split(","))
        except ValueError:
            found = ""
        if not found:
            raise CraftmeshError(
                f"material {text!r}; expected KIND:CONSTANTS or PHASE=KIND:CONSTANTS as cubic:8e3,6e3,2e3"
            )
        if key in materials:
            raise CraftmeshError(f"material {text!r}: there is one for the same phase already; keep one")
        materials[key] = Material(kind.strip(), values)
    if not materials or (None in materials and len(materials) > 1):
        raise CraftmeshError(
            "material: expected one for all phases, or each with its phase, as 1=isotropic:70e3,0.33"
        )
    return materials


def phases_of_grains(
    grains: np.ndarray,
    materials: Mapping[int | None, object],
    phases: np.ndarray | None,
    option: str = "material",
) -> dict[int, int | None]:
    """Return the key in `materials` of each of the grains (g,) by its id.

    phases (n,), row = grain id, 0 unknown; option: what gives the materials. Raises CraftmeshError for a
    phase without a material, and where there are several materials and no phases.
    """
    if None in materials:
        return dict.fromkeys(grains.tolist(), None)
    if phases is None:
        if len(materials) == 1:
            return dict.fromkeys(grains.tolist(), next(iter(materials)))
        raise CraftmeshError(
            f"{option}: {len(materials)} are given, but grains have no phase; give one for all"
        )
    found: dict[int, int | None] = {
        grain: int(phases[grain]) if grain < len(phases) else 0 for grain in grains.tolist()
    }
    for grain, phase in found.items():
        if phase not in materials:
            raise CraftmeshError(f"{option}: grain {grain} has phase {phase}; give one for it too")
    return found
