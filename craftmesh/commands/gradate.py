"""Fit the edges of a stitched surface to the sizing function: target lengths around the crack front."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import (
    add_crack,
    add_front,
    add_sizing,
    check_sizing,
    given_crack,
    sizing_from,
)
from craftmesh.commands.stage_io import add_output, add_report, tell
from craftmesh.gradation.gradate import GradateOptions, gradate
from craftmesh.io.vtk import read_surface, write_surface
from craftmesh.progress import ProgressLine


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="stitched surface .vtp")
    add_output(parser, "gradated surface .vtp")
    add_report(parser)
    add_front(parser)
    add_crack(parser, "that crack facets and fronts stay close to")
    add_sizing(parser)
    add_options(parser, GradateOptions)


def run(arguments: argparse.Namespace) -> None:
    check_sizing(arguments)
    surface = read_surface(arguments.surface)
    sizing = sizing_from(arguments, surface, arguments.front)
    crack = given_crack(arguments)
    options = options_from(arguments, GradateOptions)
    with ProgressLine("gradate") as progress:
        surface, report = gradate(surface, sizing, options, progress, crack=crack)
    write_surface(arguments.output, surface)
    tell(report, arguments.report)
