"""The flag that names the given crack to the stages after its insertion."""

import argparse
from pathlib import Path

from craftmesh.io.vtk import read_crack
from craftmesh.types import Crack

NAMED = "that was inserted: what is one crack there has plain sets, in however many pieces"


def add_crack(parser: argparse.ArgumentParser, what: str) -> None:
    """Add --crack; what: what the stage takes the crack for."""
    parser.add_argument(
        "--crack",
        type=Path,
        metavar="FILE",
        help=f"crack .vtp {what}; default the --front where that is a .vtp",
    )


def given_crack(arguments: argparse.Namespace) -> Crack | None:
    """Return the crack of --crack, or else that of --front where it is one."""
    file = arguments.crack or arguments.front
    return read_crack(file) if file is not None and (arguments.crack or file.suffix == ".vtp") else None
