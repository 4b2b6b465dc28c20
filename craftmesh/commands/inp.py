"""Write the complete input deck for Abaqus and CalculiX: sets, sections, materials, a tension step."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_microstructure, orientations_and_phases
from craftmesh.commands.stage_io import add_output, add_report, tell
from craftmesh.deck.write_deck import DeckOptions, write_deck
from craftmesh.io.vtk import read_tets


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, "input deck .inp")
    add_microstructure(parser)
    add_report(parser)
    add_options(parser, DeckOptions)


def run(arguments: argparse.Namespace) -> None:
    options = options_from(arguments, DeckOptions)
    known = orientations_and_phases(arguments)
    report = write_deck(arguments.output, read_tets(arguments.volume), options, **known)
    tell(report, arguments.report)
