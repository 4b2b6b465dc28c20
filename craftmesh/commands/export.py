"""Write the mesh for other programs, sets kept: .vtu (VTK), .msh (Gmsh 2.2), .e or .exo (Exodus II)."""

import argparse
import dataclasses
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_microstructure
from craftmesh.commands.stage_io import add_file, add_output
from craftmesh.deck.options import DeckOptions
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.mesh_formats import MESH_FORMATS
from craftmesh.io.npz import read_labels
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.orientation import normalized, quaternion_to_bunge
from craftmesh.mesh.second_order import as_elements

SUFFIXES = [f".{kind}" for kind in MESH_FORMATS]
OF_THE_MESH = ("element", "quarter_points")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, f"file in the format of its suffix: {', '.join(SUFFIXES)}")
    add_microstructure(parser)
    add_file(parser, "--angles", "write the grains' Bunge angles by block, for MOOSE, to this .csv")
    others = [field.name for field in dataclasses.fields(DeckOptions) if field.name not in OF_THE_MESH]
    add_options(parser, DeckOptions, skip=others)


def run(arguments: argparse.Namespace) -> None:
    suffix = arguments.output.suffix
    if suffix not in SUFFIXES:
        raise CraftmeshError(
            f"{arguments.output}: suffix {suffix!r}; expected one of {', '.join(SUFFIXES)}"
        )
    if arguments.output.exists() and arguments.output.samefile(arguments.volume):
        raise CraftmeshError(f"{arguments.output}: is the mesh that is read; give another name")
    options = options_from(arguments, DeckOptions)
    if arguments.angles and not arguments.microstructure:
        raise CraftmeshError("--angles needs the orientations of the grains; give --microstructure")
    mesh, _ = as_elements(read_tets(arguments.volume), options.element, bool(options.quarter_points))
    angles = block_angles(mesh.grain, arguments.microstructure) if arguments.angles else None
    MESH_FORMATS[suffix[1:]](arguments.output, mesh)
    if angles is not None:
        with atomic_path(arguments.angles) as path:
            np.savetxt(path, angles, "%.12g", ",")


def block_angles(grain: np.ndarray, labels: Path) -> np.ndarray:
    """Return phi1, PHI, phi2 (n, 3) in degrees of the blocks 1 to n, 0 where the mesh has no such grain.

    MOOSE's PropertyReadFile takes rows so, and the angles as of the active turn from crystal to sample
    axes. Raises CraftmeshError for a grain without an orientation.
    """
    given, grains = read_labels(existing(labels)).orientations, np.unique(grain)
    known = np.full((grains[-1] + 1, 4), np.nan)
    if given is not None:
        known[: len(given)] = given[: len(known)]
    angles = np.zeros((len(known), 3))
    angles[grains] = np.degrees(quaternion_to_bunge(normalized(known[grains])))
    lost = grains[np.isnan(angles[grains]).any(axis=1)]
    if len(lost):
        raise CraftmeshError(
            f"{labels}: grain {lost[0]} has no orientation ({len(lost)} such grains); give a "
            "microstructure with orientations, or leave --angles out"
        )
    return angles[1:]
