"""Fit the edges of a stitched surface to the sizing function: Eq. 2-3, around the crack front."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.sizing_flags import add_front, add_sizing, refuse_two_sizings, sizing_from
from craftmesh.commands.stage_io import add_output, add_report, tell
from craftmesh.gradation.gradate import GradateOptions, gradate
from craftmesh.io.vtk import read_crack, read_surface, write_surface
from craftmesh.progress import ProgressLine
from craftmesh.types import Crack


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="stitched surface .vtp")
    add_output(parser, "gradated surface .vtp")
    add_report(parser)
    add_front(parser)
    parser.add_argument(
        "--crack",
        type=Path,
        metavar="FILE",
        help="crack .vtp that crack facets and fronts keep to; default the --front where that is a .vtp",
    )
    add_sizing(parser)
    add_options(parser, GradateOptions)


def run(arguments: argparse.Namespace) -> None:
    refuse_two_sizings(arguments)
    surface = read_surface(arguments.surface)
    sizing = sizing_from(arguments, surface, arguments.front)
    crack = _given_crack(arguments)
    options = options_from(arguments, GradateOptions)
    with ProgressLine("gradate") as progress:
        surface, report = gradate(surface, sizing, options, progress, crack=crack)
    write_surface(arguments.output, surface)
    tell(report, arguments.report)


def _given_crack(arguments: argparse.Namespace) -> Crack | None:
    """Return the crack of --crack, or else that of --front where it is one."""
    file = arguments.crack or arguments.front
    return read_crack(file) if file is not None and (arguments.crack or file.suffix == ".vtp") else None
