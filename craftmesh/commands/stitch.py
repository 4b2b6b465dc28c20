"""Join the surfaces of the grains into one conformal surface and insert the crack."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.sizing_flags import add_sizing, refuse_two_sizings, sizing_from
from craftmesh.commands.stage_io import add_output, add_report, existing, tell
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.options import InsertOptions
from craftmesh.io.surface_files import listed_suffixes, read_grain_folder
from craftmesh.io.vtk import read_crack, read_surface, write_surface
from craftmesh.progress import ProgressLine
from craftmesh.stitching.stitch import StitchOptions, stitch_grains


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "surface", type=Path, help=f"surface .vtp, or folder of {listed_suffixes()} files, one per grain"
    )
    add_output(parser, "stitched surface .vtp")
    parser.add_argument("--crack", type=Path, metavar="FILE", help="crack .vtp to insert")
    add_report(parser)
    add_sizing(parser)
    add_options(parser, StitchOptions, InsertOptions)


def run(arguments: argparse.Namespace) -> None:
    refuse_two_sizings(arguments)
    report: dict = {}
    if existing(arguments.surface).is_dir():
        surface, report = stitch_grains(
            read_grain_folder(arguments.surface), options_from(arguments, StitchOptions)
        )
    else:
        surface = read_surface(arguments.surface)
    if arguments.crack:
        crack = read_crack(arguments.crack)
        sizing = sizing_from(arguments, surface, arguments.crack)
        with ProgressLine("stitch") as progress:
            surface, inserted = insert_crack(
                surface, crack, sizing, options_from(arguments, InsertOptions), progress
            )
        report = report | inserted
    write_surface(arguments.output, surface)
    tell(report, arguments.report)
