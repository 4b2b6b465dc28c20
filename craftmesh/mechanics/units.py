"""Names of the user's units, which label what a reader sees: nothing is converted."""

from collections.abc import Iterable
from dataclasses import dataclass

from craftmesh.options import Options, option

# Quantity that a column of sif.csv measures, for each column that has a unit.
_MEASURED = (
    dict.fromkeys(("x", "y", "z", "s", "radius", "extension"), "length")
    | dict.fromkeys(("K_I", "K_II", "K_III", "spread", "error", "driving", "delta_K"), "K")
    | {"J": "J", "G": "J", "T": "stress", "probe_stress": "stress"}
    | dict.fromkeys(("kink_angle", "probe_angle"), "angle")
    | {"da_dN": "rate"}
)


@dataclass(frozen=True)
class UnitsOptions(Options):
    """The units of the lengths and of the materials; all other units follow from them."""

    length: str = option("", "name of your unit of lengths, such as um")
    stress: str = option("", "name of your unit of stresses and moduli, such as MPa")

    def by_quantity(self) -> dict[str, str]:
        """Return the units of length, area, force, K, J and stress by name; unknown ones are left out."""
        length, stress = (" ".join(text.split()) for text in (self.length, self.stress))
        found = {"length": length, "area": f"{length}^2"} if length else {}
        if length and stress:
            found |= {
                "force": f"{stress} {length}^2",
                "K": f"{stress} sqrt({length})",
                "J": f"{stress} {length}",
            }
        return found | ({"stress": stress} if stress else {})

    def of_columns(self, names: Iterable[str]) -> dict[str, str]:
        """Return the units of columns of sif.csv; a missing unit is written as "length" or "stress"."""
        units = UnitsOptions(self.length or "length", self.stress or "stress").by_quantity()
        units |= {"angle": "degrees", "rate": f"{units['length']} per cycle"}
        return {name: units[_MEASURED[name]] for name in names if name in _MEASURED}
