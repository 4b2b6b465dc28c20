"""Crystal structures in words, from the codes and symbols with which files name them."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from craftmesh.types import Crystal

# DREAM.3D's codes 0 to 10 (Laue classes; 999 is unknown), as its filter Create Ensemble Info lists them.
_DREAM3D = (
    *("hexagonal", "cubic", "hexagonal", "cubic", "triclinic", "monoclinic", "orthorhombic"),
    *("tetragonal", "tetragonal", "trigonal", "trigonal"),
)
# The last space group of each structure (International Tables for Crystallography A).
_LAST_GROUP = MappingProxyType(
    {
        **{2: "triclinic", 15: "monoclinic", 74: "orthorhombic", 142: "tetragonal", 167: "trigonal"},
        **{194: "hexagonal", 230: "cubic"},
    }
)
# Laue groups, as Neper names symmetries beside the words themselves.
_LAUE = MappingProxyType(
    {
        **{
            "-1": "triclinic",
            "2/m": "monoclinic",
            "mmm": "orthorhombic",
            "-3": "trigonal",
            "-3m": "trigonal",
        },
        **dict.fromkeys(("4/m", "4/mmm"), "tetragonal"),
        **dict.fromkeys(("6/m", "6/mmm"), "hexagonal"),
        **dict.fromkeys(("m-3", "m-3m"), "cubic"),
    }
)


def in_words(value: bytes | str) -> str:
    """Return a text of an HDF5 file."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def of_dream3d(code: int) -> str:
    """Return the structure of a code of DREAM.3D, "" where it is unknown."""
    return _DREAM3D[code] if 0 <= code < len(_DREAM3D) else ""


def of_space_group(number: int) -> str:
    """Return the structure of a space group 1 to 230, "" for other numbers."""
    return next((word for last, word in _LAST_GROUP.items() if 1 <= number <= last), "")


def of_symmetry(word: str) -> str:
    """Return the structure of a Laue group such as m-3m, or of its own word; "" where it is neither."""
    return word if word in _LAST_GROUP.values() else _LAUE.get(word, "")


def of_grains(crystals: Mapping[int, Crystal], phases: np.ndarray | None) -> dict[int, Crystal]:
    """Return the crystals by phase; where grains have none, the only crystal as that of phase 0."""
    if phases is not None:
        return dict(crystals)
    return dict(zip([0], crystals.values())) if len(crystals) == 1 else {}


def as_table(crystals: Mapping[int, Crystal]) -> np.ndarray:
    """Return crystals as texts (k, 3): phase, structure, name."""
    return np.array([[str(phase), *crystal] for phase, crystal in crystals.items()], str).reshape(-1, 3)


def from_table(table: np.ndarray) -> dict[int, Crystal]:
    """Return the crystals of a table made by `as_table`."""
    return {int(phase): Crystal(structure, name) for phase, structure, name in table.tolist()}
