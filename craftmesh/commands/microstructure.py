"""The grains' orientations and phases, for the subcommands that make a model from a mesh."""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from craftmesh.commands.stage_io import add_file
from craftmesh.deck.options import DeckOptions
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.file_volume import of_grains
from craftmesh.io.model_tables import read_grain_strains, read_lip_field
from craftmesh.io.npz import read_labels
from craftmesh.io.point_fields import read_stress_field, read_temperature
from craftmesh.io.user_material import read_template
from craftmesh.mechanics.eigenstrains import as_strain
from craftmesh.mechanics.lips import LipField
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.orientation import element_axes
from craftmesh.mechanics.point_fields import PointField
from craftmesh.mechanics.user_materials import UserMaterials, parse_templates


def add_microstructure(parser: argparse.ArgumentParser) -> None:
    add_file(parser, "--microstructure", "labels .npz with the grains' orientations and phases")


def known_of_files(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the keyword arguments of `elastic_model` that the given files define, by name.

    --microstructure defines `orientations`, `phases` and `crystals`; --lip-field defines `lip_field`;
    --eigenstrain-file defines `grain_strains`; --residual-stress defines `residual_stress`;
    --temperature defines `temperature`. Without a file its arguments are left out.
    """
    found: dict[str, Any] = {}
    if field := getattr(arguments, "lip_field", ""):
        found["lip_field"] = LipField(*read_lip_field(field))
    if stresses := getattr(arguments, "residual_stress", ""):
        found["residual_stress"] = PointField(*read_stress_field(stresses))
    if temperatures := getattr(arguments, "temperature", ""):
        found["temperature"] = PointField(*read_temperature(temperatures))
    if strains := getattr(arguments, "eigenstrain_file", ""):
        grains, rows = read_grain_strains(strains)
        found["grain_strains"] = {grain: as_strain(row) for grain, row in zip(grains, rows)}
    if not arguments.microstructure:
        return found
    voxels = read_labels(existing(arguments.microstructure))
    crystals = of_grains(voxels.crystals, voxels.phases)
    return {"orientations": voxels.orientations, "phases": voxels.phases, "crystals": crystals} | found


def add_deck_materials(
    model: ElasticModel, options: DeckOptions, arguments: argparse.Namespace, known: Mapping[str, Any]
) -> tuple[ElasticModel, UserMaterials | None]:
    """Return the model, with element axes if options ask for them, and its user materials or None.

    known: the result of `known_of_files`. Raises CraftmeshError if element axes are asked for without
    --microstructure, or with a user material whose constants contain the axes.
    """
    materials, name = None, options.user_material
    if name:
        by_phase = parse_templates(read_template(name), f"user_material: {name}")
        materials = UserMaterials(by_phase, known.get("phases"))
    if options.orientations == "grain":
        return model, materials
    if not arguments.microstructure:
        raise CraftmeshError("orientations: element needs the voxels; give --microstructure")
    for user in materials.by_phase.values() if materials else ():
        if not user.has_sections_axes:
            raise CraftmeshError(
                f"orientations: element, but the constants of {name} contain the axes, one "
                "material per grain; use a template whose sections have axes, such as single_crystal"
            )
    axes = element_axes(model.mesh, read_labels(arguments.microstructure))
    return replace(model, element_axes=axes), materials
