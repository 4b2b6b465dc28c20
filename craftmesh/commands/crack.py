"""Make the crack surface of one increment: prescribed by its shape or by a triangulated surface."""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output, existing
from craftmesh.cracks.options import CrackOptions, surface_file
from craftmesh.cracks.series import GivenSurface, crack_of_increment, refuse_shrunk
from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import read_front_points
from craftmesh.io.npz import read_labels
from craftmesh.io.surface_files import listed_suffixes, read_triangles
from craftmesh.io.vtk import read_crack, read_surface, read_voxels, write_crack


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


def run(arguments: argparse.Namespace) -> None:
    options, increment = options_from(arguments, CrackOptions), arguments.increment
    crack = crack_of_increment(
        options, increment, box_of(arguments.volume), given_surface(options, increment)
    )
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


def box_of(path: Path) -> np.ndarray:
    """Return the lower and upper corner (2, 3) of the volume or surface in a file."""
    if existing(path).suffix == ".npz":
        return read_labels(path).box
    if path.suffix == ".vti":
        return read_voxels(path).box
    points = read_surface(path).points
    return np.stack([points.min(axis=0), points.max(axis=0)])
