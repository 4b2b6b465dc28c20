"""Join the surfaces of the grains into one conformal surface and insert the crack."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import add_sizing, check_sizing, sizing_from
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell, warn
from craftmesh.cracks.crack_tolerances import PROMISED
from craftmesh.errors import existing, listed, named
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.options import InsertOptions
from craftmesh.io.surface_files import LISTED, read_grain_folder, unnumbered
from craftmesh.io.vtk import read_crack, read_surface, write_surface
from craftmesh.progress import ProgressLine
from craftmesh.stitching.stitch import StitchOptions, stitch_grains


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "surface", type=Path, help=f"surface .vtp, or folder of {LISTED} files, one per grain"
    )
    add_output(parser, "stitched surface .vtp")
    add_file(parser, "--crack", "crack .vtp to insert")
    add_report(parser)
    add_sizing(parser)
    add_options(parser, StitchOptions, InsertOptions)


def run(arguments: argparse.Namespace) -> None:
    check_sizing(arguments)
    report: dict = {}
    if existing(arguments.surface).is_dir():
        grains, others = read_grain_folder(arguments.surface), unnumbered(arguments.surface)
        with named(arguments.surface):
            surface, report = stitch_grains(grains, options_from(arguments, StitchOptions))
        if others:
            report["notes"] = [*report["notes"], f"{listed(others)} left out: no grain id ends the name"]
    else:
        surface = read_surface(arguments.surface)
    if arguments.crack:
        sizing = sizing_from(arguments, surface, arguments.crack)
        crack, options = read_crack(arguments.crack), options_from(arguments, InsertOptions)
        with ProgressLine("stitch") as progress:
            surface, inserted = insert_crack(surface, crack, sizing, options, progress)
        if (times := inserted.get("crack_off_times", 0.0)) > 1:
            warn(
                f"the crack in the mesh is up to {times:.2g} times farther from the given crack than "
                f"allowed (facets {PROMISED.facets} l_min, front {PROMISED.front} l_min, area 0.5 %): "
                "move the crack a little, or give a shorter l_min"
            )
        report = report | inserted
    write_surface(arguments.output, surface)
    tell(report, arguments.report)
