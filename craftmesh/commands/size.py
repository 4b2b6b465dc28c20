"""Make the sizing function of one increment, once for all stages: sources, numbers and fields of lengths.

Stages that get this file by --sizing use the same lengths at the same point, whatever their surface.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import sizing_by
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell
from craftmesh.errors import existing
from craftmesh.io.npz import read_labels
from craftmesh.io.stage_npz import write_sizing
from craftmesh.io.vtk import read_surface
from craftmesh.sizing.sizing import SizingOptions, voxel_edge
from craftmesh.sizing.stored import NUMBERS, arrays_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="surface .vtp before the crack is inserted")
    add_output(parser, "sizing .npz")
    source = parser.add_mutually_exclusive_group()
    source.add_argument(
        "--crack", type=Path, metavar="FILE", dest="front", help="crack .vtp to refine around its fronts"
    )
    add_file(source, "--front", "the same for a front: .csv with columns x, y, z")
    add_file(parser, "--labels", "labels .npz: without --l0, l0 is the voxel edge of these labels")
    add_report(parser)
    add_options(parser, SizingOptions)


def run(arguments: argparse.Namespace) -> None:
    options, l0_is = options_from(arguments, SizingOptions), "given"
    if options.l0 is None and arguments.labels is None:
        l0_is = "the surface's median edge"
    elif options.l0 is None:
        l0_is = "the voxel's edge, the cube root of its volume"
        options = replace(options, l0=voxel_edge(read_labels(existing(arguments.labels))))
    sizing, notes = sizing_by(options, read_surface(arguments.surface), arguments.front)
    arrays = arrays_of(sizing)
    write_sizing(arguments.output, arrays)
    numbers = {name: getattr(sizing, name) for name in NUMBERS}
    fields: dict[str, Any] = {"sources": len(sizing.sources), "fields_of_lengths": len(sizing.others)}
    fields |= {"notes": notes} if notes else {}
    tell(numbers | {"l0_is": l0_is, "growth": sizing.growth} | fields, arguments.report)
