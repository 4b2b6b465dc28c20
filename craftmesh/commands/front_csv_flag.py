"""The flag that has the ordered crack fronts written beside the mesh."""

import argparse
from pathlib import Path

from craftmesh.types import TetMesh


def add_front_csv(parser: argparse.ArgumentParser) -> None:
    """Add --front-csv."""
    parser.add_argument(
        "--front-csv", type=Path, metavar="FILE", help="ordered front nodes with their frames"
    )


def write_front_csv(arguments: argparse.Namespace, mesh: TetMesh) -> None:
    """Write the fronts of the second-order mesh to the file of --front-csv, where it is given."""
    if arguments.front_csv is None:
        return
    from craftmesh.io.front_csv import write_front
    from craftmesh.mesh.front_frames import front_frames
    from craftmesh.mesh.second_order import raise_order

    write_front(arguments.front_csv, front_frames(raise_order(mesh)).columns())
