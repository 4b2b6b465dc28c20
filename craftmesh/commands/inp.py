"""Write the complete input deck for Abaqus and CalculiX: sets, sections, materials, a tension step."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_microstructure, known_of_files, user_materials
from craftmesh.commands.stage_io import add_output, add_report, add_units, tell, warn
from craftmesh.deck.limits import deck_warning
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_model
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.model import elastic_model
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
    materials = user_materials(options.user_material, known)
    write_model(arguments.output, model, options, materials, UnitsOptions(*arguments.units))
    for warning in filter(None, [*report.get("notes", ()), deck_warning(model)]):
        warn(warning)
    tell(report, arguments.report)
