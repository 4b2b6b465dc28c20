"""Write the mesh for other programs, sets kept: .vtu (VTK), .msh (Gmsh 2.2), .e or .exo (Exodus II)."""

import argparse
import dataclasses
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output
from craftmesh.deck.options import DeckOptions
from craftmesh.errors import CraftmeshError
from craftmesh.io.mesh_formats import MESH_FORMATS
from craftmesh.io.vtk import read_tets
from craftmesh.mesh.second_order import as_elements

SUFFIXES = [f".{kind}" for kind in MESH_FORMATS]
OF_THE_MESH = ("element", "quarter_points")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, f"file in the format of its suffix: {', '.join(SUFFIXES)}")
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
    mesh, _ = as_elements(read_tets(arguments.volume), options.element, bool(options.quarter_points))
    MESH_FORMATS[suffix[1:]](arguments.output, mesh)
