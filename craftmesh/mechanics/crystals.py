"""Checks of materials against the crystals of a file, and materials known by crystal structure and name."""

from collections.abc import Mapping

import numpy as np
import scipy

from craftmesh.mechanics.materials import Material, parse_materials, turned
from craftmesh.types import Crystal

# Rotations (axis, degrees) that leave the elastic constants of every crystal class of a structure
# unchanged. Source: J. F. Nye, Physical Properties of Crystals (1985), table 9.
_TURNS = {
    "cubic": (("x", 90), ("z", 90)),
    "hexagonal": (("z", 60),),
    "tetragonal": (("z", 90),),
    "trigonal": (("z", 120),),
    "orthorhombic": (("x", 180), ("z", 180)),
}
# Largest change of the stiffness by such a rotation, relative to the largest constant: constants are
# measured to about a percent.
_MISFIT = 0.01
# Constants in MPa at room temperature.
# Source: G. Simmons and H. Wang, Single Crystal Elastic Constants (1971).
METALS = {
    "aluminium": "cubic:106750,60410,28340",
    "copper": "cubic:168400,121400,75400",
    "nickel": "cubic:246500,147300,124700",
    "magnesium": "hexagonal:59700,26200,21700,61700,16400",
    "titanium": "hexagonal:162400,92000,69000,180700,46700",
    "zirconium": "hexagonal:143400,72800,65300,164800,32000",
}


def misfits(
    phase_of: Mapping[int, int | None],
    materials: Mapping[int | None, Material],
    phases: np.ndarray | None,
    crystals: Mapping[int, Crystal],
) -> list[str]:
    """Return a sentence for each phase whose material lacks the symmetry of its crystal.

    phase_of: key in `materials` by grain id; phases (n,): row = grain id, None if all grains are of phase
    0; crystals: by phase. An isotropic material fits every crystal.
    """
    pairs = {(0 if phases is None else int(phases[grain]), key) for grain, key in phase_of.items()}
    found = []
    for phase, key in sorted(pairs, key=lambda pair: pair[0]):
        crystal, material = crystals.get(phase, Crystal()), materials[key]
        stiffness = material.stiffness()
        for axis, degrees in _TURNS.get(crystal.structure, ()):
            matrix = scipy.spatial.transform.Rotation.from_euler(axis, degrees, degrees=True).as_matrix()
            change = np.abs(turned(stiffness, matrix) - stiffness).max() / np.abs(stiffness).max()
            if change > _MISFIT:
                name = " ".join(crystal.name.split())
                found.append(
                    f"phase {phase}{f' ({name})' * bool(name)} is {crystal.structure} in its file, but its "
                    f"material ({material.kind}) is not: rotating by {degrees} degrees about the crystal's "
                    f"{axis} axis changes the stiffness by {100 * change:.0f} %; check inp.material"
                )
                break
    return found


def known_material(crystal: Crystal) -> tuple[str, str, bool]:
    """Return a material text for a crystal, its description, and True if it only stands in for the crystal.

    A metal of METALS that has the crystal's structure and name does not only stand in. Other crystals get
    copper if their structure is cubic or unknown, titanium if it is hexagonal, and an isotropic material
    for other structures, whose own constants would be 21 numbers.
    """
    name = {"aluminum": "aluminium"}.get(crystal.name.strip().lower(), crystal.name.strip().lower())
    text = METALS.get(name, "")
    if text and text.partition(":")[0] == crystal.structure:
        return text, f"{name} (Simmons and Wang, 1971)", False
    metal = {"": "copper", "cubic": "copper", "hexagonal": "titanium"}.get(crystal.structure)
    if metal is None:
        return "isotropic:200000,0.3", f"isotropic, for a {crystal.structure} crystal's constants", True
    return METALS[metal], metal, True


def described_materials(
    materials: Mapping[int | None, Material], crystals: Mapping[int, Crystal]
) -> dict[int | None, str]:
    """Return a description of each material by its key in `materials`, a phase or None for all phases.

    It has kind and constants, the name of a metal with these constants, and whether the material only
    stands in for the crystal. crystals: by phase, as in `Voxels`; key None gets the crystal of phase 0.
    """
    found = {}
    for phase, material in materials.items():
        text, what, is_stand_in = known_material(crystals.get(phase or 0, Crystal()))
        words = f"{material.kind} {', '.join(f'{x:g}' for x in material.constants)}"
        metals = [name for name, known in METALS.items() if parse_materials([known])[None] == material]
        if is_stand_in and parse_materials([text])[None] == material:
            own = " ".join(" ".join(crystals.get(phase or 0, Crystal())).split()) or "an unnamed material"
            words = f"{what}, which stands in for {own}; give yours as inp.material"
        found[phase] = f"{metals[0]} ({words})" if metals and not words.startswith(metals[0]) else words
    return found
