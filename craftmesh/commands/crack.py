"""Make the crack surface of one increment, prescribed by its shape or by a triangulated surface."""

from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output, existing
from craftmesh.cracks.series import crack_of_increment
from craftmesh.cracks.shapes import CrackOptions
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import read_labels
from craftmesh.io.vtk import read_crack, read_surface, read_voxels, write_crack
from craftmesh.surface.measure import area_vectors
from craftmesh.types import Crack


def add_arguments(parser):
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


def run(arguments):
    crack = crack_of_increment(
        options_from(arguments, CrackOptions), arguments.increment, box_of(arguments.volume)
    )
    if arguments.previous:
        before, now = area(read_crack(arguments.previous)), area(crack)
        if now < before * (1 - 1e-9):
            raise CraftmeshError(
                f"crack of increment {arguments.increment}: area {now:.6g} is below {before:.6g} of the "
                "increment before; expected a crack that grows"
            )
    write_crack(arguments.output, crack)


def box_of(path: Path) -> np.ndarray:
    """Return the lower and upper corner (2, 3) of the volume or surface in a file."""
    if existing(path).suffix == ".npz":
        return read_labels(path).box
    if path.suffix == ".vti":
        return read_voxels(path).box
    points = read_surface(path).points
    return np.stack([points.min(axis=0), points.max(axis=0)])


def area(crack: Crack) -> float:
    """Return the area of a crack's surface."""
    return float(np.linalg.norm(area_vectors(crack.points, crack.triangles), axis=1).sum())
