"""The grains' orientations and phases: the flag of the verbs that make a model of a mesh."""

import argparse
from pathlib import Path
from typing import Any

from craftmesh.commands.stage_io import existing
from craftmesh.io.crystals import of_grains
from craftmesh.io.npz import read_labels


def add_microstructure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--microstructure",
        type=Path,
        metavar="FILE",
        help="labels .npz with the grains' orientations and phases",
    )


def orientations_and_phases(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return `orientations`, `phases` and `crystals` of the labels that the flag names, empty without."""
    if not arguments.microstructure:
        return {}
    voxels = read_labels(existing(arguments.microstructure))
    crystals = of_grains(voxels.crystals, voxels.phases)
    return {"orientations": voxels.orientations, "phases": voxels.phases, "crystals": crystals}
