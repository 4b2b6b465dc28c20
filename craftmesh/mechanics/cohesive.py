"""Traction-separation laws of cohesive layers on grain boundaries, by class of boundary."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import named_numbers
from craftmesh.types import Crystal

if TYPE_CHECKING:
    from craftmesh.mechanics.model import ElasticModel

ALL, LOW_ANGLE, NO_LAYER = "all", "low_angle", "none"
LOW = 15.0  # degrees: boundaries of a smaller disorientation are arrays of dislocations (Brandon 1966)
# Rotation group of scipy that maps a crystal of each structure onto itself.
_GROUPS = {"cubic": "O", "hexagonal": "D6", "tetragonal": "D4", "trigonal": "D3", "orthorhombic": "D2"}


@dataclass(frozen=True)
class CohesiveLaw:
    """A traction-separation law: stiffness (stress / length), strength (stress), energy (stress * length).

    shear_...: values tangential to the boundary; 0 means the value normal to it. With strength and energy
    of 0 there is no damage. Damage begins where the sum of squared ratios of stress to strength reaches 1.
    The energies of mixed modes follow Benzeggagh & Kenane (1996) with the power eta. viscosity: time by
    which damage lags behind the separation.
    """

    stiffness: float
    shear_stiffness: float = 0.0
    strength: float = 0.0
    shear_strength: float = 0.0
    energy: float = 0.0
    shear_energy: float = 0.0
    eta: float = 2.0
    viscosity: float = 0.0

    def __post_init__(self) -> None:
        for name in ("stiffness", "strength", "energy"):
            if not getattr(self, f"shear_{name}"):
                object.__setattr__(self, f"shear_{name}", getattr(self, name))

    def with_lengths(self, scale: float) -> "CohesiveLaw":
        """Return the law in another unit of length: stiffness over `scale`, energies times `scale`.

        scale: a length's number in the new unit over its number in the old one. Stresses keep their unit.
        """
        parts = {f.name: getattr(self, f.name) for f in fields(self)}
        return replace(
            self,
            **{name: value / scale for name, value in parts.items() if "stiffness" in name},
            **{name: value * scale for name, value in parts.items() if "energy" in name},
        )


@dataclass(frozen=True, eq=False)
class CohesiveLayers:
    """Laws and elements (k, 6) by pair of grains (a < b).

    An element has three nodes on grain a, then the three nodes on grain b at the same positions.
    """

    laws: Mapping[tuple[int, int], CohesiveLaw]
    elements: Mapping[tuple[int, int], np.ndarray]


Scope = str | tuple[int, int]


def parse_cohesive(texts: Iterable[str]) -> dict[Scope, CohesiveLaw | None]:
    """Return laws by the boundaries to which they apply; None means no layer there.

    A key is ALL, LOW_ANGLE (low-angle boundaries) or a pair of grains (a < b). texts such as
    "all:stiffness=1e6,strength=300,energy=0.5", "low_angle:none" or "3-7:stiffness=2e6". Raises
    CraftmeshError for texts of another form and for two texts of one key.
    """
    found: dict[Scope, CohesiveLaw | None] = {}
    for text in texts:
        head, _, rest = (part.strip() for part in text.partition(":"))
        scope, law = _scope(head), _law(rest)
        if scope is None or (law is None and rest != NO_LAYER) or scope in found:
            names = ", ".join(f.name for f in fields(CohesiveLaw)[1:])
            raise CraftmeshError(
                f"cohesive: {text!r}; expected {ALL}:, {LOW_ANGLE}: or two grains as 3-7:, each once, then "
                f"{NO_LAYER}, or stiffness= and any of {names}, separated by commas; give numbers > 0, and "
                "strength and energy both or neither"
            )
        found[scope] = law
    return found


def _scope(head: str) -> Scope | None:
    first, dash, second = head.partition("-")
    if not dash:
        return head if head in (ALL, LOW_ANGLE) else None
    if not (first.strip().isdecimal() and second.strip().isdecimal()) or int(first) == int(second):
        return None
    a, b = sorted((int(first), int(second)))
    return a, b


def _law(text: str) -> CohesiveLaw | None:
    """Return the law of a text of NAME=NUMBER pairs; None if it is not a valid law."""
    values, known = named_numbers(text.split(",")), {f.name for f in fields(CohesiveLaw)}
    if values is None or not {"stiffness"} <= values.keys() <= known:
        return None
    is_whole = ("strength" in values) == ("energy" in values) and min(values.values()) > 0
    return CohesiveLaw(**values) if is_whole else None


def laws_of_pairs(
    texts: Iterable[str],
    pairs: Sequence[tuple[int, int]],
    model: "ElasticModel",
    phases: np.ndarray | None = None,
    crystals: Mapping[int, Crystal] | None = None,
) -> dict[tuple[int, int], CohesiveLaw]:
    """Return the laws of the pairs (a < b) that have a layer.

    A pair's law is that of its own text, else of low_angle if its disorientation is below LOW, else of all.
    pairs: grains with a common boundary; phases (n,): row = grain id; crystals: by phase. Raises
    CraftmeshError if a text names another pair, and if a disorientation is needed but orientations or the
    crystal's symmetry are unknown.
    """
    rows = parse_cohesive(texts)
    lost = [scope for scope in rows if isinstance(scope, tuple) and scope not in pairs]
    if lost:
        raise CraftmeshError(
            f"cohesive: {lost[0][0]}-{lost[0][1]}: these grains share no face outside the crack; name one "
            f"of the {len(pairs)} boundaries of the mesh"
        )
    found = {}
    for pair in pairs:
        scope: Scope = pair
        if pair not in rows:
            is_low = LOW_ANGLE in rows and _disorientation(pair, model, phases, crystals or {}) < LOW
            scope = LOW_ANGLE if is_low else ALL
        law = rows.get(scope)
        if law is not None:
            found[pair] = law
    return found


def _disorientation(
    pair: tuple[int, int],
    model: "ElasticModel",
    phases: np.ndarray | None,
    crystals: Mapping[int, Crystal],
) -> float:
    """Return the disorientation of two grains in degrees; 180 if their phases differ.

    It is the smallest rotation angle over all symmetrically equivalent orientations. Raises CraftmeshError
    if an orientation or the symmetry is unknown.
    """
    of = [0 if phases is None else int(phases[grain]) for grain in pair]
    if of[0] != of[1]:
        return 180.0
    kind = model.materials[model.phase_of[pair[0]]].kind
    structure = crystals[of[0]].structure if of[0] in crystals else kind
    if structure not in _GROUPS or not set(pair) <= set(model.axes):
        raise CraftmeshError(
            f"cohesive: {LOW_ANGLE}: the disorientation of grains {pair[0]} and {pair[1]} is unknown; "
            "give orientations and a material with a crystal symmetry "
            f"(now {kind}), or name the pairs of grains"
        )
    one, other = (scipy.spatial.transform.Rotation.from_matrix(model.own_axes(grain)) for grain in pair)
    turns = one.inv() * other * scipy.spatial.transform.Rotation.create_group(_GROUPS[structure])
    return float(np.degrees(turns.magnitude().min()))
