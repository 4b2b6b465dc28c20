"""Merge the grains' tetrahedra by surface node and open the crack."""

from pathlib import Path

from craftmesh.assemble import assemble
from craftmesh.commands.stage_io import add_output, add_report, tell
from craftmesh.crack_front import front_frames
from craftmesh.io.front_csv import write_front
from craftmesh.io.grain_tets import read_grain_tets
from craftmesh.io.vtk import read_surface, write_tets


def add_arguments(parser):
    parser.add_argument("surface", type=Path, help="the gradated surface .vtp that was tetrahedralized")
    parser.add_argument("chunks", type=Path, nargs="+", metavar="CHUNK", help="chunks of grains .npz")
    add_output(parser, "mesh .vtu with the crack opened")
    parser.add_argument(
        "--front-csv", type=Path, metavar="FILE", help="ordered front nodes with their frames"
    )
    add_report(parser)


def run(arguments):
    grain_tets = [grain for chunk in arguments.chunks for grain in read_grain_tets(chunk)]
    mesh, report = assemble(read_surface(arguments.surface), grain_tets)
    if arguments.front_csv:
        write_front(arguments.front_csv, front_frames(mesh).columns())
    write_tets(arguments.output, mesh)
    tell(report, arguments.report)
