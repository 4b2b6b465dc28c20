"""Solve for the displacements of the deck's model: built-in solver, CalculiX, Abaqus, or from a file."""

import argparse
import shutil
import time
from functools import partial
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_deck_materials, add_microstructure, known_of_files
from craftmesh.commands.run_deck import run_deck, solved_history
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell, warn
from craftmesh.deck.options import OF_THE_FILE, DeckOptions
from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import write_front
from craftmesh.io.model_tables import DISPLACEMENT_FORMAT, read_displacement_table, read_displacements
from craftmesh.io.point_fields import NAMES
from craftmesh.io.stage_npz import write_solution_vtu, write_solutions
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.stress import grain_stress
from craftmesh.mechanics.user_materials import UserMaterials
from craftmesh.mesh.tet_connectivity import grains_at_nodes
from craftmesh.progress import ProgressLine
from craftmesh.solve.options import ABAQUS, BUILTIN, CALCULIX, EXTERNAL, FIELD, SolveOptions, waited_for
from craftmesh.solve.solve import solve_model
from craftmesh.types import TetMesh


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, "solution .npz: displacements and reactions by the deck's nodes")
    add_file(parser, "--vtu", "write displacements and stresses for ParaView")
    add_file(
        parser, "--slip-table", "write slip by plane and stress at nodes, for grow.criterion slip, a .csv"
    )
    add_microstructure(parser)
    add_file(
        parser,
        "--field",
        f"displacements for solver `external` (default {FIELD} next to the output)",
    )
    parser.add_argument(
        "--work",
        type=Path,
        metavar="FOLDER",
        help="where calculix and abaqus run; kept (default: next to the output, removed at the end)",
    )
    add_report(parser)
    add_options(parser, DeckOptions, SolveOptions, skip=OF_THE_FILE)


def run(arguments: argparse.Namespace) -> None:
    options, deck = options_from(arguments, SolveOptions), options_from(arguments, DeckOptions)
    options.check_takes(bool(deck.cohesive), bool(deck.history), deck.has_plates)
    if deck.cohesive:
        warn("cohesive layers are only in the deck; this field, and K from it, do not include them")
    known = known_of_files(arguments)
    model, counts = elastic_model(read_tets(arguments.volume), deck, **known)
    start = time.monotonic()
    output, stress, slip, materials = arguments.output, None, None, None
    folder = arguments.work or output.with_name(f"{output.stem}_{options.solver}")
    if deck.history and options.solver != BUILTIN:
        model, materials = add_deck_materials(model, deck, arguments, known)
        solution, stress, slip, report = solved_history(model, options, deck, materials, folder)
        solutions = {"": solution}
    else:
        field_of = partial(_field_of, options, arguments.field or output.with_name(FIELD), folder)
        with ProgressLine("solve") as progress:
            solutions, report = solve_model(model, options, progress, field_of)
    if options.solver in (CALCULIX, ABAQUS) and not arguments.work:
        shutil.rmtree(folder)
    write_solutions(output, solutions)
    if arguments.slip_table:
        _write_slip(arguments.slip_table, model.mesh, slip, stress, materials)
    if arguments.vtu:
        displacement = next(iter(solutions.values())).displacement
        found, mesh = grain_stress(model, displacement), model.mesh
        node, values = found.node, found.stress if stress is None else stress[found.node]
        slipped = None if slip is None else slip[node].sum(axis=1)
        fields = mesh.grain, node + 1, displacement[node], values, slipped
        write_solution_vtu(arguments.vtu, mesh.points[node], found.tets, *fields)
    seconds = round(time.monotonic() - start, 1)
    tell(counts | {"solver": options.solver} | report | {"seconds": seconds}, arguments.report)


def _field_of(
    options: SolveOptions, given: Path, folder: Path, model: ElasticModel, case: str
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return node numbers (k,), displacements (k, 3) in the model's unit, and the path of their file.

    A program runs in `folder` / `case`; solver external reads the file `given`, with the load case in its
    name. Raises CraftmeshError if the program fails, for results that cannot be read, and if the external
    file does not exist.
    """
    read = read_displacements if options.solver == CALCULIX else read_displacement_table
    if options.solver != EXTERNAL:
        path = run_deck(model, options, folder / case)
    else:
        (path,) = waited_for(given, [case] if case else [])
        if not path.exists():
            raise CraftmeshError(
                f"solver external: waits for {path}: {DISPLACEMENT_FORMAT}, a row for each node 1 to "
                f"{len(model.mesh.points)} of the deck that `craftmesh inp` writes with the same options; "
                "write this file and start again"
            )
    numbers, displacement = read(path)
    return numbers, displacement / model.scale, str(path)


def _write_slip(
    path: Path,
    mesh: TetMesh,
    slip: np.ndarray | None,
    stress: np.ndarray | None,
    materials: UserMaterials | None,
) -> None:
    """Write a table of nodes, the slip on each plane, summed over its slip systems, and the stress.

    `read_slip_table` reads it. slip (n, s): slip of s systems at the nodes; stress (n, 6). Nodes that
    grains share are left out, because their values are means over these grains. Raises CraftmeshError if
    no material assigns planes to s systems.
    """
    of = [one.slip_planes for one in materials.by_phase.values()] if materials else []
    planes = next((names for names in of if slip is not None and len(names) == slip.shape[1]), ())
    if slip is None or stress is None or not planes:
        raise CraftmeshError(
            "--slip-table: the user material does not assign state variables to the slip of planes; "
            "give its template slip and slip_planes of equal length"
        )
    lowest, highest = grains_at_nodes(mesh.tets, mesh.grain)
    inner = np.flatnonzero(lowest == highest)
    columns = {f"slip_{plane}": np.zeros(len(inner)) for plane in planes}
    for plane, own in zip(planes, slip[inner].T):
        columns[f"slip_{plane}"] += own
    columns |= dict(zip(NAMES, stress[inner].T))
    write_front(path, {"points": mesh.points[inner], "grain": lowest[inner]} | columns)
