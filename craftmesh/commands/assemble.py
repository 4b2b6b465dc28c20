"""Merge the grains' tetrahedra by surface node and open the crack.

If grains are left without tetrahedra, or the mesher is tetwild, this subcommand meshes the whole model.
Last, surface points move within the surface to improve tetrahedra, unless --no-optimise is given. Give the
same sizes and options as to tetrahedralize.
"""

import argparse
from functools import partial
from pathlib import Path

from craftmesh.assembly.assemble import refuse_other_surface
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import check_sizing, given_sizing
from craftmesh.commands.mesh_output import add_mesh_flags, write_assembled
from craftmesh.commands.stage_io import add_output, warn
from craftmesh.io.stage_npz import read_grain_tets, read_record
from craftmesh.io.vtk import read_surface
from craftmesh.progress import ProgressLine
from craftmesh.surface.repair import repair_surface
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.record import merged
from craftmesh.tetrahedra.volume import Volume, complete_volume


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="the gradated surface .vtp that was tetrahedralized")
    parser.add_argument("chunks", type=Path, nargs="+", metavar="CHUNK", help="chunks of grains .npz")
    add_output(parser, "mesh .vtu with the crack opened")
    add_mesh_flags(parser)
    add_options(parser, TetrahedralizeOptions)


def run(arguments: argparse.Namespace) -> None:
    check_sizing(arguments)
    surface = read_surface(arguments.surface)
    grain_tets = [grain for chunk in arguments.chunks for grain in read_grain_tets(chunk)]
    record = merged([read_record(chunk) for chunk in arguments.chunks])
    if record.get("repair"):
        surface, _ = repair_surface(surface)
    options = options_from(arguments, TetrahedralizeOptions)
    refuse_other_surface(surface, grain_tets)
    sizing = partial(given_sizing, arguments, surface)
    with ProgressLine("whole model") as progress:
        volume = complete_volume(Volume(surface, grain_tets, record), sizing, options, progress)
    warn(*volume.warnings)
    write_assembled(arguments, volume, {})
