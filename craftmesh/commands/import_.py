"""Read a labelled microstructure, clean it, and find its voids and embedded grains."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_file, add_report, tell
from craftmesh.errors import CraftmeshError, existing, named
from craftmesh.io.json_file import write_json
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import write_voxels
from craftmesh.progress import ProgressLine
from craftmesh.voxels.clean import clean
from craftmesh.voxels.islands import find_islands, islands_as_json
from craftmesh.voxels.options import CleanOptions
from craftmesh.voxels.reading import ReadOptions, read_voxels


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", type=Path, help="microstructure file, or folder of TIFF slices")
    for flag, what in (
        ("--image", "volume .vti for viewing"),
        ("--labels", "cleaned volume .npz that GRAIN_<id> refers to"),
        ("--islands", "voids and embedded grains .json"),
    ):
        add_file(parser, flag, what)
    add_report(parser)
    add_options(parser, ReadOptions, CleanOptions)


def run(arguments: argparse.Namespace) -> None:
    if not (arguments.image or arguments.labels or arguments.islands):
        raise CraftmeshError("nothing to write; give at least one of --labels, --image, --islands")
    options = options_from(arguments, CleanOptions)
    read = options_from(arguments, ReadOptions)
    raw = read_voxels(existing(arguments.input), read, fills=options.fill_unindexed)
    with ProgressLine("import") as progress, named(arguments.input):
        voxels, report = clean(raw, options, progress)
    islands = find_islands(voxels)
    if arguments.image:
        write_voxels(arguments.image, voxels)
    if arguments.islands:
        write_json(arguments.islands, islands_as_json(islands))
    if arguments.labels:
        write_labels(arguments.labels, voxels)
    tell(report, arguments.report)
