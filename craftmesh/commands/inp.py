"""Write the complete input deck for Abaqus and CalculiX: sets, sections, materials, a tension step."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output, add_report, existing, tell
from craftmesh.deck.write_deck import DeckOptions, write_deck
from craftmesh.io.npz import read_labels
from craftmesh.io.vtk import read_tets


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, "input deck .inp")
    parser.add_argument(
        "--microstructure",
        type=Path,
        metavar="FILE",
        help="labels .npz with the grains' orientations and phases",
    )
    add_report(parser)
    add_options(parser, DeckOptions)


def run(arguments: argparse.Namespace) -> None:
    options = options_from(arguments, DeckOptions)
    known = {}
    if arguments.microstructure:
        voxels = read_labels(existing(arguments.microstructure))
        known = {"orientations": voxels.orientations, "phases": voxels.phases}
    report = write_deck(arguments.output, read_tets(arguments.volume), options, **known)
    tell(report, arguments.report)
