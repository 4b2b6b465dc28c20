"""Materials of user subroutines: templates of constants, filled in for each grain."""

import re
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import number_of
from craftmesh.mechanics.materials import phases_of_grains
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.orientation import matrix_to_quaternion, quaternion_to_bunge
from craftmesh.options import Options, option

_ANGLES = ("phi1", "PHI", "phi2")
_QUATERNION = ("q0", "q1", "q2", "q3")
_MATRIX = tuple(f"r{row}{column}" for row in "123" for column in "123")
_TURN = {*_ANGLES, *_QUATERNION, *_MATRIX}
_KNOWN = (*_ANGLES, *_QUATERNION, *_MATRIX, "grain", "phase")
_PLACEHOLDER = re.compile(r"\{(\w+)\}")
_OUTPUT = "*NODE FILE, FREQUENCY={every}\nU, RF\n*EL FILE, FREQUENCY={every}\nS, E, ENER, SDV\n"


@dataclass(frozen=True)
class UserMaterial(Options):
    """The material of a user subroutine, with constants that may depend on the grain.

    Raises CraftmeshError if a value is neither a number nor a placeholder, and if there are not as many
    values as `constants` says.
    """

    constants: int = option(MISSING, "number of values", at_least=1)
    values: tuple[float | str, ...] = option(
        MISSING,
        "numbers and placeholders: {phi1}, {PHI}, {phi2} the grain's Bunge angles in degrees; {q0} to {q3} "
        "quaternion w, x, y, z and {r11} to {r33} matrix from crystal to sample axes; {grain}, {phase}",
    )
    depvar: int = option(0, "number of state variables at each integration point", at_least=0)
    name: str = option("MATERIAL", "start of the materials' names")
    oriented: bool = option(True, "whether the material has axes, and so each grain needs an orientation")
    nlgeom: bool = option(False, "whether steps use finite strain")
    unsymmetric: bool = option(False, "whether the subroutine's tangent is unsymmetric, for Abaqus' solver")
    output: str = option(_OUTPUT, "lines of each step that request output; {every} is inp.output_every")
    slip: tuple[int, int] | None = option(
        None, "first and last of the state variables that add up to accumulated slip, from 1", at_least=1
    )
    slip_planes: tuple[str, ...] = option(
        (), "plane of each of these, as 111 or 1-11; craftmesh solve --slip-table has a column for each"
    )
    about: str = option("", "description of the subroutine for readers of the template")

    def __post_init__(self) -> None:
        super().__post_init__()
        numbers = [number_of(value) if isinstance(value, str) else value for value in self.values]
        # YAML reads 1.e6 as a text
        values = tuple(
            text if number is None else float(number) for text, number in zip(self.values, numbers)
        )
        object.__setattr__(self, "values", values)
        for value in values:
            found = _PLACEHOLDER.fullmatch(value) if isinstance(value, str) else None
            if isinstance(value, str) and (found is None or found[1] not in _KNOWN):
                raise CraftmeshError(
                    f"values has {value!r}; expected numbers, and placeholders in quotes: "
                    f"{', '.join(f'{{{name}}}' for name in _KNOWN)}"
                )
        if len(self.values) != self.constants:
            raise CraftmeshError(
                f"values has {len(self.values)} entries but constants is {self.constants}; make them equal"
            )

    @property
    def placeholders(self) -> set[str]:
        """Names of the placeholders among the values."""
        return {value[1:-1] for value in self.values if isinstance(value, str)}

    @property
    def has_sections_axes(self) -> bool:
        """True if the deck's sections give the crystal's axes.

        The material then has axes, but no placeholder for them among its values.
        """
        return self.oriented and not self.placeholders & _TURN


@dataclass(frozen=True, eq=False)
class UserMaterials:
    """User materials by phase (None: all phases); phases (n,): row = grain id, None if unknown."""

    by_phase: Mapping[int | None, UserMaterial]
    phases: np.ndarray | None = None

    def of_grains(self, model: ElasticModel) -> dict[int, tuple[str, UserMaterial, list[float]]]:
        """Return (name, material, constants) of each grain of a model, by grain id.

        Placeholders are replaced by the grain's values; {phase} is 1 if phases are unknown. Grains share a
        name if only the phase, or nothing, is replaced. Raises CraftmeshError for a phase without a
        material, and for a grain without an orientation whose material needs one.
        """
        keys = phases_of_grains(model.grains, self.by_phase, self.phases, "user_material")
        found = {}
        for grain, key in keys.items():
            material = self.by_phase[key]
            if material.oriented and grain not in model.axes:
                raise CraftmeshError(
                    f"user_material: grain {grain} has no orientation; give orientations with the "
                    "microstructure, or a template with oriented: false"
                )
            name = material.name + (f"_PHASE_{key}" if key is not None else "")
            name += f"_GRAIN_{grain}" if material.placeholders - {"phase"} else ""
            phase = 1 if self.phases is None or grain >= len(self.phases) else int(self.phases[grain])
            known = _known(model, grain, phase)
            values = [known[value[1:-1]] if isinstance(value, str) else value for value in material.values]
            found[grain] = name, material, values
        return found


def _known(model: ElasticModel, grain: int, phase: int) -> dict[str, float]:
    """Return the value of each placeholder for a grain, by name."""
    matrix = model.own_axes(grain)
    quaternion = matrix_to_quaternion(matrix[None])[0]
    angles = np.degrees(quaternion_to_bunge(quaternion))
    values = [*angles.tolist(), *quaternion.tolist(), *matrix.ravel().tolist(), grain, phase]
    return dict(zip(_KNOWN, values))


def parse_templates(content: Any, source: str) -> dict[int | None, UserMaterial]:
    """Return user materials by phase from the content of a template; key None for all phases.

    content: the fields of `UserMaterial` by name, or `phases` with such fields by phase; fields next to
    `phases` apply to all phases. Raises CraftmeshError for other content; source begins its message.
    """
    expected = [field.name for field in fields(UserMaterial)]
    if not isinstance(content, Mapping):
        raise CraftmeshError(f"{source}: not a template; expected the keys {', '.join(expected)}")
    common = {key: value for key, value in content.items() if key != "phases"}
    by_phase = content.get("phases", {None: {}})
    if not isinstance(by_phase, Mapping) or not all(isinstance(own, Mapping) for own in by_phase.values()):
        raise CraftmeshError(
            f"{source}: phases is {by_phase!r}; expected the keys of each phase by its number"
        )
    found: dict[int | None, UserMaterial] = {}
    for phase, own in by_phase.items():
        keys = common | own
        wrong = [f"key {key!r}" for key in keys if key not in expected]
        wrong += [f"no {key}" for key in ("constants", "values") if key not in keys]
        wrong += [f"phase {phase!r}"] * (phase is not None and type(phase) is not int)
        if wrong:
            raise CraftmeshError(f"{source}: has {wrong[0]}; expected {', '.join(expected)}, or phases")
        try:
            found[phase] = UserMaterial(**keys)
        except CraftmeshError as error:
            raise CraftmeshError(f"{source}: {error}") from None
    return found
