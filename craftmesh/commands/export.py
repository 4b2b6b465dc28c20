"""Write the mesh for other programs: .vtu (VTK), .msh (Gmsh 2.2), .e, .exo (Exodus II); grains as .csv."""

import argparse
import dataclasses
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import stored_sizing
from craftmesh.commands.microstructure import add_microstructure
from craftmesh.commands.stage_io import add_file, add_output
from craftmesh.deck.options import DeckOptions
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.front_csv import write_front
from craftmesh.io.mesh_formats import EXPORTS, GRAIN_TABLE, MESH_FORMATS, ExportOptions
from craftmesh.io.npz import read_labels
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.orientation import normalized, quaternion_to_bunge
from craftmesh.mesh.lips import lips_apart
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.mesh.second_order import as_elements

SUFFIXES = [f".{kind}" for kind in EXPORTS]
OF_THE_MESH = ("element", "quarter_points")  # options of a deck that also concern other formats
HEALED = (
    "note: both faces of a crack coincide, each with nodes of its own; programs that merge coincident "
    "nodes heal the crack: --opening 0.01 moves the faces apart"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, f"file in the format of its suffix: {', '.join(SUFFIXES)}")
    add_microstructure(parser)
    add_file(parser, "--sizing", "sizing .npz of `craftmesh size`, which has the l_min of --opening")
    add_file(parser, "--angles", "write the grains' Bunge angles by block, for MOOSE, to this .csv")
    add_options(parser, ExportOptions)
    others = [field.name for field in dataclasses.fields(DeckOptions) if field.name not in OF_THE_MESH]
    add_options(parser, DeckOptions, skip=others)


def run(arguments: argparse.Namespace) -> None:
    suffix = arguments.output.suffix
    if suffix not in SUFFIXES:
        raise CraftmeshError(
            f"{arguments.output}: suffix {suffix!r}; expected one of {', '.join(SUFFIXES)}"
        )
    if arguments.output.exists() and arguments.output.samefile(arguments.volume):
        raise CraftmeshError(f"{arguments.output}: is the input mesh; choose another output name")
    options, written = options_from(arguments, DeckOptions), options_from(arguments, ExportOptions)
    kind, labels = suffix[1:], arguments.microstructure
    if (arguments.angles or kind == GRAIN_TABLE) and not labels:
        raise CraftmeshError(
            f"{arguments.angles or arguments.output} needs the orientations of the grains; "
            "give --microstructure"
        )
    if written.opening and not arguments.sizing:
        raise CraftmeshError("--opening is in units of l_min, which the sizing has; give --sizing")
    mesh, _ = as_elements(read_tets(arguments.volume), options.element, bool(options.quarter_points))
    grains, row = np.unique(mesh.grain, return_inverse=True)
    known, phases = known_of_grains(grains, labels)
    angles = block_angles(grains, known, labels) if arguments.angles else None
    if kind == GRAIN_TABLE:
        bunge = np.degrees(quaternion_to_bunge(known))
        columns = {"grain": grains, "phase": phases} | dict(zip("wxyz", known.T))
        write_front(arguments.output, columns | dict(zip(("phi1", "Phi", "phi2"), bunge.T)))
    else:
        turned = known[row] if np.isfinite(known).any() else None
        beside: dict[str, dict] = {"vtu": {"quaternions": turned}, "msh": {"ascii": written.ascii}}
        if written.opening:
            mesh = lips_apart(mesh, written.opening * stored_sizing(arguments.sizing).l_min)
        elif any(map(is_lip, mesh.face_sets)):
            print(HEALED)
        MESH_FORMATS[kind](arguments.output, mesh, **beside.get(kind, {}))
    if angles is not None:
        with atomic_path(arguments.angles) as path:
            np.savetxt(path, angles, "%.12g", ",")


def known_of_grains(grains: np.ndarray, labels: Path | None) -> tuple[np.ndarray, np.ndarray]:
    """Return quaternions (k, 4), NaN if unknown, and phases (k,), -1 if unknown, of grains (k,).

    labels: path of the labels .npz; None: all are unknown.
    """
    quaternions, phases = np.full((len(grains), 4), np.nan), np.full(len(grains), -1)
    if labels:
        voxels = read_labels(existing(labels))
        for found, given in ((quaternions, voxels.orientations), (phases, voxels.phases)):
            if given is not None:
                found[grains < len(given)] = given[grains[grains < len(given)]]
    return normalized(quaternions), phases


def block_angles(grains: np.ndarray, known: np.ndarray, labels: Path) -> np.ndarray:
    """Return Bunge angles (n, 3) in degrees, row k - 1 for grain k; 0 for ids that the mesh does not have.

    MOOSE's PropertyReadFile reads these rows and takes the angles as the active rotation from crystal to
    sample axes. known: quaternions (k, 4) of the grains (k,), ids in ascending order; labels: their file,
    for the error. Raises CraftmeshError if a quaternion is NaN.
    """
    lost = grains[~np.isfinite(known).all(axis=1)]
    if len(lost):
        raise CraftmeshError(
            f"{labels}: grain {lost[0]} has no orientation ({len(lost)} such grains); give a "
            "microstructure with orientations, or leave --angles out"
        )
    angles = np.zeros((grains[-1] + 1, 3))
    angles[grains] = np.degrees(quaternion_to_bunge(known))
    return angles[1:]
