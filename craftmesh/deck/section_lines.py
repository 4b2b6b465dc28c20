"""Lines of the deck for what the grains are made of: materials, orientations and sections."""

from collections.abc import Iterator

from craftmesh.deck.inp_format import constant_lines
from craftmesh.mechanics.materials import Material
from craftmesh.mechanics.model import ElasticModel


def section_lines(model: ElasticModel) -> Iterator[str]:
    """Yield the materials in use, then orientation and section of each grain."""
    for phase in sorted(set(model.phase_of.values()), key=lambda phase: phase or 0):
        yield from _material_lines(phase, model.materials[phase])
    for grain, phase in model.phase_of.items():
        orientation = ""
        if grain in model.axes:
            yield f"*ORIENTATION, NAME=ORI_{grain}, SYSTEM=RECTANGULAR\n"
            yield from constant_lines(model.axes[grain].tolist())
            orientation = f", ORIENTATION=ORI_{grain}"
        yield f"*SOLID SECTION, ELSET=GRAIN_{grain}, MATERIAL={_material_name(phase)}{orientation}\n"


def _material_lines(phase: int | None, material: Material) -> Iterator[str]:
    yield f"*MATERIAL, NAME={_material_name(phase)}\n"
    if material.kind == "isotropic":
        yield "*ELASTIC\n"
        yield from constant_lines(list(material.constants))
    else:
        yield "*ELASTIC, TYPE=ANISOTROPIC\n"
        yield from constant_lines(material.upper_triangle())


def _material_name(phase: int | None) -> str:
    return "MATERIAL" if phase is None else f"PHASE_{phase}"
