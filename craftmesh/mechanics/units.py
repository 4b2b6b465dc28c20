"""Names of the user's units, labels beside what a reader sees: nothing is converted."""

from dataclasses import dataclass

from craftmesh.options import Options, option


@dataclass(frozen=True)
class UnitsOptions(Options):
    """The units of the lengths and of the materials; the others follow from them."""

    length: str = option("", "name of your unit of lengths, such as um")
    stress: str = option("", "name of your unit of stresses and moduli, such as MPa")

    def by_quantity(self) -> dict[str, str]:
        """Return the units of length, area, force, K, J and stress; those not known are left out."""
        length, stress = (" ".join(text.split()) for text in (self.length, self.stress))
        found = {"length": length, "area": f"{length}^2"} if length else {}
        if length and stress:
            found |= {
                "force": f"{stress} {length}^2",
                "K": f"{stress} sqrt({length})",
                "J": f"{stress} {length}",
            }
        return found | ({"stress": stress} if stress else {})
