"""Materials are held against the crystals of a file, and the known ones are sound."""

import numpy as np
import pytest

from craftmesh.mechanics.crystals import METALS, known_material, misfits
from craftmesh.mechanics.materials import parse_materials
from craftmesh.types import Crystal

COPPER, TITANIUM, STEEL = METALS["copper"], METALS["titanium"], "isotropic:200000,0.3"


def of_21(text: str) -> str:
    return "anisotropic:" + ",".join(map(repr, parse_materials([text])[None].upper_triangle()))


@pytest.mark.parametrize("form", [str, of_21])  # the constants count, not the kind
@pytest.mark.parametrize(
    ("structure", "text", "fits"),
    [
        ("cubic", COPPER, True),
        ("cubic", TITANIUM, False),
        ("hexagonal", TITANIUM, True),
        ("hexagonal", COPPER, False),
        ("hexagonal", METALS["aluminium"], False),  # Zener's ratio is 1.2
        ("trigonal", COPPER, False),
        ("tetragonal", COPPER, True),  # a cubic crystal has its turns too
        ("orthorhombic", TITANIUM, True),
        *((structure, STEEL, True) for structure in ("cubic", "hexagonal", "trigonal", "")),
        ("", COPPER, True),
        ("triclinic", COPPER, True),
    ],
)
def test_a_material_fits_a_crystal_whose_turns_it_has(form, structure, text, fits):
    said = misfits({1: None, 2: None}, parse_materials([form(text)]), None, {0: Crystal(structure, "a\nb")})
    assert len(said) == (not fits)
    for line in said:
        assert line.startswith(f"phase 0 (a b) is {structure} in its file") and "\n" not in line


def test_each_phase_is_held_against_its_own_crystal():
    materials = parse_materials([f"1={COPPER}", f"2={COPPER}"])
    crystals = {1: Crystal("cubic"), 2: Crystal("hexagonal", "Ti"), 3: Crystal("hexagonal")}
    (said,) = misfits({4: 1, 5: 2, 6: 2}, materials, np.array([0, 0, 0, 3, 1, 2, 2]), crystals)
    assert said.startswith("phase 2 (Ti) is hexagonal")


@pytest.mark.parametrize("name", METALS)
def test_known_metals_are_taken_by_name_and_structure(name):
    kind = METALS[name].partition(":")[0]
    assert known_material(Crystal(kind, name.capitalize()))[::2] == (METALS[name], False)
    other = {"cubic": "hexagonal", "hexagonal": "cubic"}[kind]
    text, _, is_stand_in = known_material(Crystal(other, name))
    assert is_stand_in and text.startswith(other)
    assert misfits({1: None}, parse_materials([METALS[name]]), None, {0: Crystal(kind)}) == []
    # Born's criteria hold, and Young's modulus of the aggregate is that of a metal
    assert 30e3 < np.trace(parse_materials([METALS[name]])[None].stiffness()) / 6 < 400e3


@pytest.mark.parametrize("structure", ["", "cubic", "hexagonal", "trigonal", "triclinic"])
def test_what_stands_in_fits_the_structure_and_says_what_it_is(structure):
    text, what, is_stand_in = known_material(Crystal(structure, "Unobtainium"))
    assert is_stand_in and what and "Unobtainium" not in what
    assert misfits({1: None}, parse_materials([text]), None, {0: Crystal(structure)}) == []
