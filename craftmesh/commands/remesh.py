"""Turn a labelled volume into one conformal, smoothed surface: multi-material marching cubes."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output, add_report, tell
from craftmesh.errors import existing
from craftmesh.io.npz import read_labels
from craftmesh.io.vtk import write_surface
from craftmesh.progress import ProgressLine
from craftmesh.remeshing.remesh import RemeshOptions, remesh


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("labels", type=Path, help="cleaned volume .npz of `craftmesh import`")
    add_output(parser, "surface .vtp")
    add_report(parser)
    add_options(parser, RemeshOptions)


def run(arguments: argparse.Namespace) -> None:
    voxels = read_labels(existing(arguments.labels))
    with ProgressLine("remesh") as progress:
        surface, report = remesh(voxels, options_from(arguments, RemeshOptions), progress)
    write_surface(arguments.output, surface)
    tell(report, arguments.report)
