"""Lines of the deck for grains whose materials are those of user subroutines."""

from collections.abc import Iterator

from craftmesh.deck.inp_format import constant_lines
from craftmesh.deck.section_lines import orientation_lines
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.user_materials import UserMaterials


def user_section_lines(model: ElasticModel, materials: UserMaterials) -> Iterator[str]:
    """Yield the user materials, each once, then orientation and section of each grain.

    Sections have no orientation where the constants hold it.
    """
    found = materials.of_grains(model)
    written = set()
    for name, material, values in found.values():
        if name not in written:
            written.add(name)
            yield f"*MATERIAL, NAME={name}\n*USER MATERIAL, CONSTANTS={material.constants}\n"
            yield from constant_lines(values)
            if material.depvar:
                yield f"*DEPVAR\n{material.depvar}\n"
    for grain, (name, material, _) in found.items():
        orientation = ""
        if material.has_sections_axes:
            yield from orientation_lines(model, grain, model.axes[grain].tolist())
            orientation = f", ORIENTATION=ORI_{grain}"
        yield f"*SOLID SECTION, ELSET=GRAIN_{grain}, MATERIAL={name}{orientation}\n"
