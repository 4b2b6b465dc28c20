"""Write the complete input deck for Abaqus and CalculiX: sets, sections, materials, steps."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from craftmesh.assembly.boundary_layers import boundary_layers, grain_pairs
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_deck_materials, add_microstructure, known_of_files
from craftmesh.commands.stage_io import add_output, add_report, add_units, tell, warn
from craftmesh.deck.limits import deck_warning
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_model
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.cohesive import CohesiveLayers, laws_of_pairs
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.units import UnitsOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, "input deck .inp")
    add_microstructure(parser)
    add_units(parser, "the deck's heading")
    add_report(parser)
    add_options(parser, DeckOptions)


def run(arguments: argparse.Namespace) -> None:
    options = options_from(arguments, DeckOptions)
    known = known_of_files(arguments)
    model, report = elastic_model(read_tets(arguments.volume), options, **known)
    model, materials = add_deck_materials(model, options, arguments, known)
    layers = None
    if options.cohesive:
        model, layers = _with_layers(model, options, known)
        report |= {"nodes": len(model.mesh.points), "cohesive_boundaries": len(layers.laws)}
        report |= {"cohesive_elements": sum(map(len, layers.elements.values()))}
    units = UnitsOptions(*arguments.units)
    write_model(arguments.output, model, options, materials, units, layers=layers)
    warn(*report.get("notes", ()), deck_warning(model))
    tell(report, arguments.report)


def _with_layers(
    model: ElasticModel, options: DeckOptions, known: Mapping[str, Any]
) -> tuple[ElasticModel, CohesiveLayers]:
    """Return the model opened along grain boundaries, and its cohesive layers.

    The loads are kept from the body before it is opened. known: as from `known_of_files`.
    """
    pairs = grain_pairs(model.mesh)
    laws = laws_of_pairs(options.cohesive, pairs, model, known.get("phases"), known.get("crystals"))
    opened, elements = boundary_layers(model.mesh, laws)
    if options.element == "C3D10" and any(law.strength for law in laws.values()):
        warn(
            "cohesive: on faces of C3D10 tractions oscillate about the true values, by 5 % if stiffness * "
            "edge / E is 0.05 and by 59 % if 1; for damage use element C3D4, or less stiffness"
        )
    return model.on_copies(opened), CohesiveLayers(laws, elements)
