"""Lines of the deck for cohesive layers on grain boundaries."""

from collections.abc import Iterator

import numpy as np

from craftmesh.deck.inp_format import constant_lines, integer_rows, name_lines
from craftmesh.mechanics.cohesive import CohesiveLaw, CohesiveLayers


def layer_lines(layers: CohesiveLayers, first: int) -> Iterator[str]:
    """Yield the elements, numbered from `first`, in the sets COH_<a>_<b> and COH_ALL."""
    names = [_name(pair) for pair, rows in layers.elements.items() if len(rows)]
    for pair, rows in layers.elements.items():
        if len(rows):
            yield f"*ELEMENT, TYPE=COH3D6, ELSET={_name(pair)}\n"
            yield from integer_rows(np.column_stack([first + np.arange(len(rows)), rows + 1]))
            first += len(rows)
    if names:
        yield "*ELSET, ELSET=COH_ALL\n"
        yield from name_lines(names)


def layer_section_lines(layers: CohesiveLayers, scale: float) -> Iterator[str]:
    """Yield the laws as materials COHESIVE_<k>, lengths times `scale`, and a section for each boundary."""
    laws = list(dict.fromkeys(layers.laws.values()))
    for count, law in enumerate(laws, 1):
        yield from _law_lines(f"COHESIVE_{count}", law.with_lengths(scale))
    for pair, law in layers.laws.items():
        if len(layers.elements[pair]):
            name = f"COHESIVE_{laws.index(law) + 1}"
            yield f"*COHESIVE SECTION, ELSET={_name(pair)}, MATERIAL={name}, RESPONSE=TRACTION SEPARATION, "
            yield f"THICKNESS=SPECIFIED, CONTROLS={name}\n1.0\n"


def _name(pair: tuple[int, int]) -> str:
    return f"COH_{pair[0]}_{pair[1]}"


def _law_lines(name: str, law: CohesiveLaw) -> Iterator[str]:
    yield f"*SECTION CONTROLS, NAME={name}, ELEMENT DELETION=YES, VISCOSITY={law.viscosity!r}\n"
    yield f"*MATERIAL, NAME={name}\n*ELASTIC, TYPE=TRACTION\n"
    yield from constant_lines([law.stiffness, law.shear_stiffness, law.shear_stiffness])
    if law.strength:
        yield "*DAMAGE INITIATION, CRITERION=QUADS\n"
        yield from constant_lines([law.strength, law.shear_strength, law.shear_strength])
        yield f"*DAMAGE EVOLUTION, TYPE=ENERGY, MIXED MODE BEHAVIOR=BK, POWER={law.eta!r}\n"
        yield from constant_lines([law.energy, law.shear_energy, law.shear_energy])
