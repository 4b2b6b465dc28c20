"""Mesh an increment as the mesh before with a renewed part; if that fails, make the mesh from scratch.

Elements that neither the new part of the crack nor a changed target length touches keep their nodes,
numbers and bits.
"""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import add_filling, checked_workers, given_islands, stored_sizing
from craftmesh.commands.mesh_output import write_mesh
from craftmesh.commands.stage_io import add_file, add_output, add_report, warn
from craftmesh.errors import CraftmeshError
from craftmesh.gradation.gradate import GradateOptions
from craftmesh.insertion.options import InsertOptions
from craftmesh.io.stage_npz import read_map, write_map
from craftmesh.io.vtk import read_crack, read_surface, read_tets
from craftmesh.progress import ProgressLine
from craftmesh.renewal.options import RenewOptions
from craftmesh.renewal.renew import History, StageOptions, history_of, renew_mesh
from craftmesh.tetrahedra.options import TetrahedralizeOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("before", type=Path, help="mesh .vtu of the increment before")
    parser.add_argument("surface", type=Path, help="remeshed surface .vtp, without a crack")
    add_output(parser, "mesh .vtu with the crack opened")
    for flag, what in (
        ("--crack", "crack .vtp, which contains the crack of the increment before"),
        ("--sizing", "sizing .npz of this increment"),
        ("--sizing-before", "sizing .npz of the increment before"),
    ):
        parser.add_argument(flag, type=Path, required=True, metavar="FILE", help=what)
    add_file(parser, "--map-before", "map .npz of the increment before, if that was renewed, too")
    add_file(parser, "--map", "write node and element numbers, old to new, to this .npz")
    add_file(parser, "--front-csv", "ordered front nodes with their frames")
    add_filling(parser)
    add_report(parser)
    add_options(parser, RenewOptions, InsertOptions, GradateOptions, TetrahedralizeOptions)


def run(arguments: argparse.Namespace) -> None:
    workers = checked_workers(arguments)
    kinds = RenewOptions, InsertOptions, GradateOptions, TetrahedralizeOptions
    options = StageOptions(*(options_from(arguments, kind) for kind in kinds))
    mesh, sizing = read_tets(arguments.before), stored_sizing(arguments.sizing)
    if arguments.map_before is None:
        history = history_of(mesh, stored_sizing(arguments.sizing_before))
    else:
        arrays = read_map(arguments.map_before)
        history = History(arrays["lengths"], float(arrays["aspect_ratio"]), float(arrays["cell"]))
    if len(history.lengths) != len(mesh.points):
        raise CraftmeshError(
            f"{arguments.map_before}: has lengths of {len(history.lengths)} nodes, but {arguments.before} "
            f"has {len(mesh.points)} nodes; give the map of that mesh"
        )
    islands = given_islands(arguments)
    crack, surface = read_crack(arguments.crack), read_surface(arguments.surface)
    with ProgressLine("renew") as progress:
        found = renew_mesh(mesh, history, surface, crack, sizing, options, islands, workers, progress)
    warn(*found.warnings)
    if arguments.map is not None:
        write_map(arguments.map, found.numbers._asdict() | found.history._asdict())
    write_mesh(arguments, found.mesh, found.report)
