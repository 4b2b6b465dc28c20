"""Merge the grains' tetrahedra by surface node and open the crack.

Where grains are left without tetrahedra, or with mesher tetwild, the whole model is meshed here; last,
points slide within the surface, which --no-optimise omits: give the same sizes and options as to
tetrahedralize.
"""

import argparse
from pathlib import Path

from craftmesh.commands.crack_flag import NAMED, add_crack, given_crack
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.front_csv_flag import add_front_csv, write_front_csv
from craftmesh.commands.sizing_flags import add_front, add_sizing, is_sized, refuse_two_sizings, sizing_from
from craftmesh.commands.stage_io import add_output, add_report, tell
from craftmesh.commands.whole_model_step import complete_mesh
from craftmesh.io.stage_npz import read_grain_tets, read_record
from craftmesh.io.vtk import read_surface, write_tets
from craftmesh.sizing.lengths import Lengths
from craftmesh.surface.repair import repair_surface
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.record import merged


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="the gradated surface .vtp that was tetrahedralized")
    parser.add_argument("chunks", type=Path, nargs="+", metavar="CHUNK", help="chunks of grains .npz")
    add_output(parser, "mesh .vtu with the crack opened")
    add_front_csv(parser)
    add_report(parser)
    add_front(parser)
    add_crack(parser, NAMED)
    add_sizing(parser)
    add_options(parser, TetrahedralizeOptions)


def run(arguments: argparse.Namespace) -> None:
    refuse_two_sizings(arguments)
    surface = read_surface(arguments.surface)
    grain_tets = [grain for chunk in arguments.chunks for grain in read_grain_tets(chunk)]
    record = merged([read_record(chunk) for chunk in arguments.chunks])
    if record.get("repair"):
        surface, _ = repair_surface(surface)

    def sizing() -> Lengths | None:
        return sizing_from(arguments, surface, arguments.front) if is_sized(arguments) else None

    mesh, report = complete_mesh(
        surface,
        grain_tets,
        record,
        sizing,
        options_from(arguments, TetrahedralizeOptions),
        given_crack(arguments),
    )
    write_front_csv(arguments, mesh)
    write_tets(arguments.output, mesh)
    tell(report, arguments.report)
