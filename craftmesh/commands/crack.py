"""Make the crack surface of one increment: prescribed by its shape or by a triangulated surface."""

import argparse
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output, existing
from craftmesh.cracks.along_faces import refuse_along_faces
from craftmesh.cracks.options import CrackOptions, surface_file
from craftmesh.cracks.series import GivenSurface, crack_of_increment, refuse_shrunk
from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import read_front_points
from craftmesh.io.npz import read_labels
from craftmesh.io.surface_files import listed_suffixes, read_triangles
from craftmesh.io.vtk import read_crack, read_surface, read_voxels, write_crack
from craftmesh.sizing.sizing import SizingOptions, median_edge, sizing_for, voxel_edge

LENGTHS = ("l_min", "l0")  # of the sizing: those that l_min depends on


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "volume", type=Path, help="labels .npz, volume .vti or surface .vtp that gives the box"
    )
    add_output(parser, "crack surface .vtp with its fronts as lines")
    parser.add_argument("--increment", type=int, default=0, metavar="K", help="0, 1, ... (default 0)")
    parser.add_argument(
        "--previous",
        type=Path,
        metavar="FILE",
        help="crack .vtp of the increment before; refuse a smaller one",
    )
    add_options(parser, CrackOptions)
    others = (item.name for item in fields(SizingOptions) if item.name not in LENGTHS)
    add_options(parser, SizingOptions, skip=others)


def run(arguments: argparse.Namespace) -> None:
    options, increment = options_from(arguments, CrackOptions), arguments.increment
    box, edge = box_and_edge(arguments.volume)
    crack = crack_of_increment(options, increment, box, given_surface(options, increment))
    refuse_along_faces(crack, box, l_min_of(options_from(arguments, SizingOptions), edge))
    if arguments.previous:
        refuse_shrunk(crack, read_crack(arguments.previous), increment)
    write_crack(arguments.output, crack)


def given_surface(options: CrackOptions, increment: int) -> GivenSurface | None:
    """Return the surface of `increment` from its file; None for the prescribed shapes.

    The lines of a .vtp are its fronts; a front in options.front (csv) goes before them.
    """
    if options.shape != "surface":
        return None
    path = surface_file(options, increment)
    if not path.is_file():
        raise CraftmeshError(
            f"crack.file {path} does not exist; expected a triangulated surface .vtp, {listed_suffixes()}"
        )
    if path.suffix.lower() != ".vtp":
        surface = GivenSurface(*read_triangles(path))
    else:
        known = read_crack(path)
        surface = GivenSurface(
            known.points, known.triangles, tuple(known.points[front] for front in known.fronts)
        )
    if not options.front:
        return surface
    return replace(surface, fronts=(read_front_points(Path(options.front)),))


def box_and_edge(path: Path) -> tuple[np.ndarray, float]:
    """Return the box (2, 3) of the volume or surface in a file, and its voxel's or its median edge."""
    if existing(path).suffix in (".npz", ".vti"):
        voxels = read_labels(path) if path.suffix == ".npz" else read_voxels(path)
        return voxels.box, voxel_edge(voxels)
    surface = read_surface(path)
    return np.stack([surface.points.min(axis=0), surface.points.max(axis=0)]), median_edge(surface)


def l_min_of(options: SizingOptions, edge: float) -> float:
    """Return the least target length; `edge` is l0 where the options give none."""
    if options.l0 is None:
        options = replace(options, l0=edge)
    return sizing_for(None, options, np.zeros((0, 3))).l_min
