"""Lines of the deck for the materials, orientations and sections of grains and cohesive layers."""

from collections.abc import Iterator

import numpy as np

from craftmesh.deck.inp_format import constant_lines
from craftmesh.deck.mesh_lines import layer_name
from craftmesh.mechanics.cohesive import CohesiveLaw, CohesiveLayers
from craftmesh.mechanics.eigenstrains import is_even
from craftmesh.mechanics.materials import Material
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.user_materials import UserMaterials
from craftmesh.surface.rounding import EXACT

AXES_TABLE = "AXES"


def section_lines(model: ElasticModel) -> Iterator[str]:
    """Yield the materials in use, then orientation and section of each grain.

    If a grain's eigenstrain has shears, its section gets the principal axes, in which it has none, because
    programs define the shears of an expansion differently. The constants are then in these axes too.
    """
    names, written = _material_names(model), set()
    for row in sorted(range(len(names)), key=lambda row: model.phase_of[int(model.grains[row])] or 0):
        if names[row] not in written:
            written.add(names[row])
            material = model.materials[model.phase_of[int(model.grains[row])]]
            yield from _material_lines(names[row], material, model.own_strain[row])
    for grain, name, strain in zip(model.grains.tolist(), names, model.own_strain):
        axes = model.axes[grain].tolist() if grain in model.axes else None
        if _has_shears(strain):
            axes = (model.own_axes(grain) @ _principal_axes(strain))[:, :2].T.ravel().tolist()
        yield from _section(model, grain, name, axes)


def user_section_lines(model: ElasticModel, materials: UserMaterials) -> Iterator[str]:
    """Yield the user materials, each once, then orientation and section of each grain.

    A section has no orientation if the material's constants contain it, or if the material has no axes.
    """
    found = materials.of_grains(model)
    written = set()
    for name, material, values in found.values():
        if name not in written:
            written.add(name)
            unsymmetric = ", UNSYMM" if material.unsymmetric else ""
            yield f"*MATERIAL, NAME={name}\n*USER MATERIAL, CONSTANTS={material.constants}{unsymmetric}\n"
            yield from constant_lines(values)
            if material.depvar:
                yield f"*DEPVAR\n{material.depvar}\n"
    for grain, (name, material, _) in found.items():
        axes = model.axes[grain].tolist() if material.has_sections_axes else None
        yield from _section(model, grain, name, axes)


def _section(model: ElasticModel, grain: int, material: str, axes: list[float] | None) -> Iterator[str]:
    """Yield the section of a grain, after its orientation if `axes` (6,) are given."""
    orientation = ""
    if axes is not None:
        yield from orientation_lines(model, grain, axes)
        orientation = f", ORIENTATION=ORI_{grain}"
    yield f"*SOLID SECTION, ELSET=GRAIN_{grain}, MATERIAL={material}{orientation}\n"


def orientation_lines(model: ElasticModel, grain: int, axes: list[float]) -> Iterator[str]:
    """Yield the orientation of a grain; axes: the sample components (6,) of its first two axes.

    If elements of the grain have axes of their own, the orientation is a distribution over elements, with
    `axes` as the default.
    """
    own, of_elements = np.zeros(0, int), model.element_axes
    if of_elements is not None:
        own = np.flatnonzero((model.mesh.grain == grain) & np.isfinite(of_elements).all(axis=1))
    if of_elements is not None and len(own):
        yield f"*DISTRIBUTION, NAME=ELEMENTS_{grain}, LOCATION=ELEMENT, TABLE={AXES_TABLE}\n"
        yield "," + "".join(constant_lines(axes))
        for row, values in zip(own.tolist(), of_elements[own].tolist()):
            yield f"{row + 1}," + "".join(constant_lines(values))
        yield f"*ORIENTATION, NAME=ORI_{grain}, SYSTEM=RECTANGULAR\nELEMENTS_{grain}\n"
        return
    yield f"*ORIENTATION, NAME=ORI_{grain}, SYSTEM=RECTANGULAR\n"
    yield from constant_lines(axes)


def _material_names(model: ElasticModel) -> list[str]:
    """Return each grain's material name: one per phase, or one per grain if eigenstrains differ in it."""
    grains = model.grains.tolist()
    strains: dict[int | None, set[bytes]] = {}
    for grain, strain in zip(grains, model.own_strain):
        strains.setdefault(model.phase_of[grain], set()).add(strain.tobytes())
    names = {phase: "MATERIAL" if phase is None else f"PHASE_{phase}" for phase in strains}
    phases = [(grain, model.phase_of[grain]) for grain in grains]
    return [names[phase] + f"_GRAIN_{grain}" * (len(strains[phase]) > 1) for grain, phase in phases]


def _has_shears(strain: np.ndarray) -> bool:
    shears = np.abs(strain - np.diag(np.diag(strain)))
    return bool(shears.max() > EXACT * np.abs(strain).max())


def _principal_axes(strain: np.ndarray) -> np.ndarray:
    """Return the principal axes of a strain (3, 3) as columns, right-handed."""
    axes = np.linalg.eigh(strain)[1]
    return axes * np.sign(np.linalg.det(axes))


def _material_lines(name: str, material: Material, strain: np.ndarray) -> Iterator[str]:
    if _has_shears(strain):
        axes = _principal_axes(strain)
        material, strain = material.in_axes(axes), axes.T @ strain @ axes
    yield f"*MATERIAL, NAME={name}\n"
    if material.kind == "isotropic":
        yield "*ELASTIC\n"
        yield from constant_lines(list(material.constants))
    else:
        yield "*ELASTIC, TYPE=ANISOTROPIC\n"
        yield from constant_lines(material.upper_triangle())
    if strain.any():
        even = is_even(strain)
        yield f"*EXPANSION, TYPE={'ISO' if even else 'ORTHO'}\n"
        yield from constant_lines(np.diag(strain)[: 1 if even else 3].tolist())


def layer_section_lines(layers: CohesiveLayers, scale: float) -> Iterator[str]:
    """Yield the laws as materials COHESIVE_<k> in the deck's unit, and a section for each boundary.

    scale: lengths in the deck over lengths of the laws. Boundaries without elements get no section.
    """
    laws = list(dict.fromkeys(layers.laws.values()))
    for count, law in enumerate(laws, 1):
        yield from _law_lines(f"COHESIVE_{count}", law.with_lengths(scale))
    for pair, law in layers.laws.items():
        if len(layers.elements[pair]):
            name = f"COHESIVE_{laws.index(law) + 1}"
            yield (
                f"*COHESIVE SECTION, ELSET={layer_name(pair)}, MATERIAL={name}, "
                f"RESPONSE=TRACTION SEPARATION, THICKNESS=SPECIFIED, CONTROLS={name}\n1.0\n"
            )


def _law_lines(name: str, law: CohesiveLaw) -> Iterator[str]:
    yield f"*SECTION CONTROLS, NAME={name}, ELEMENT DELETION=YES, VISCOSITY={law.viscosity!r}\n"
    yield f"*MATERIAL, NAME={name}\n*ELASTIC, TYPE=TRACTION\n"
    yield from constant_lines([law.stiffness, law.shear_stiffness, law.shear_stiffness])
    if law.strength:
        yield "*DAMAGE INITIATION, CRITERION=QUADS\n"
        yield from constant_lines([law.strength, law.shear_strength, law.shear_strength])
        yield f"*DAMAGE EVOLUTION, TYPE=ENERGY, MIXED MODE BEHAVIOR=BK, POWER={law.eta!r}\n"
        yield from constant_lines([law.energy, law.shear_energy, law.shear_energy])
