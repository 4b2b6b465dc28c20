"""Lines of the deck for what the grains are made of: materials, orientations and sections."""

from collections.abc import Iterator

import numpy as np

from craftmesh.deck.inp_format import constant_lines
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.materials import Material, phases_of_grains
from craftmesh.mechanics.orientation import normalized, quaternion_to_matrix


def crystal_axes(grains: np.ndarray, orientations: np.ndarray | None) -> dict[int, np.ndarray]:
    """Return per grain of known orientation the sample components (6,) of its axes [100] and [010].

    grains (g,) ids; orientations (n, 4) quaternions, row = grain id, NaN unknown.
    """
    if orientations is None:
        return {}
    grains = grains[grains < len(orientations)]
    matrices = quaternion_to_matrix(normalized(orientations[grains]))
    return {
        grain: matrix[:, :2].T.ravel()
        for grain, matrix in zip(grains.tolist(), matrices)
        if np.isfinite(matrix).all()
    }


def section_lines(
    grains: np.ndarray,
    axes: dict[int, np.ndarray],
    materials: dict[int | None, Material],
    phases: np.ndarray | None,
) -> Iterator[str]:
    """Yield the materials in use, then orientation and section of each of the grains (g,).

    axes: as `crystal_axes` gives them; materials by phase; phases (n,): row = grain id. Raises
    CraftmeshError for a grain without material, and for cubic and anisotropic ones without an orientation.
    """
    phase_of = phases_of_grains(grains, materials, phases)
    unoriented = [g for g in phase_of if g not in axes and materials[phase_of[g]].kind != "isotropic"]
    if unoriented:
        kind = materials[phase_of[unoriented[0]]].kind
        raise CraftmeshError(
            f"material: {kind} needs an orientation per grain, and {len(unoriented)} have none (the first: "
            f"{unoriented[0]}); give orientations with the microstructure, or an isotropic material"
        )
    for phase in sorted(set(phase_of.values()), key=lambda phase: phase or 0):
        yield from _material_lines(phase, materials[phase])
    for grain, phase in phase_of.items():
        orientation = ""
        if grain in axes:
            yield f"*ORIENTATION, NAME=ORI_{grain}, SYSTEM=RECTANGULAR\n"
            yield from constant_lines(axes[grain].tolist())
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
