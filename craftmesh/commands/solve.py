"""Find the displacements of the deck's model: by the built-in solver, CalculiX, Abaqus or from a file."""

import argparse
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_microstructure, as_in_deck, known_of_files
from craftmesh.commands.run_deck import run_deck, solved_history
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell, warn
from craftmesh.deck.options import OF_THE_FILE, DeckOptions
from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import write_front
from craftmesh.io.model_tables import FORM, read_displacement_table, read_displacements
from craftmesh.io.stage_npz import write_solution_vtu, write_solutions
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.user_materials import UserMaterials
from craftmesh.progress import ProgressLine
from craftmesh.solve.options import BUILTIN, CALCULIX, EXTERNAL, FIELD, SolveOptions, waited_for
from craftmesh.solve.problem import foreign_solution
from craftmesh.solve.solve import memory_of, solve, solve_combinations
from craftmesh.solve.stress import grain_stress
from craftmesh.types import Solution


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, "solution .npz: displacements and reactions by the deck's nodes")
    add_file(parser, "--vtu", "write displacements and stresses for ParaView")
    add_file(parser, "--slip-table", "write the slip of planes at nodes, for grow.criterion slip, a .csv")
    add_microstructure(parser)
    add_file(
        parser,
        "--field",
        f"the displacements that `external` waits for (default {FIELD} beside the output)",
    )
    parser.add_argument(
        "--work",
        type=Path,
        metavar="FOLDER",
        help="where calculix and abaqus run; kept (default: beside the output, removed in the end)",
    )
    add_report(parser)
    add_options(parser, DeckOptions, SolveOptions, skip=OF_THE_FILE)


def run(arguments: argparse.Namespace) -> None:
    options, deck = options_from(arguments, SolveOptions), options_from(arguments, DeckOptions)
    options.check_takes(bool(deck.cohesive), bool(deck.history), deck.has_plates)
    if deck.cohesive:
        warn("cohesive layers are in the deck alone; this field, and K by it, are those of the welded body")
    known = known_of_files(arguments)
    mesh = read_tets(arguments.volume)
    model, counts = elastic_model(mesh, deck, **known)
    start = time.monotonic()
    stress = slip = materials = None
    if deck.history and options.solver != BUILTIN:
        model, materials = as_in_deck(model, deck, arguments, known)
        with _folder(options, arguments) as folder:
            (solution, stress, slip), report = solved_history(model, options, deck, materials, folder)
        solutions = {"": solution}
    elif model.combinations:
        solutions, report = _combinations(model, options, arguments)
    else:
        solution, report = _solution(model, options, arguments)
        solutions = {"": solution}
    write_solutions(arguments.output, solutions)
    if arguments.slip_table:
        _write_slip(arguments.slip_table, model.mesh.points, slip, materials)
    if arguments.vtu:
        _write_vtu(arguments.vtu, model, next(iter(solutions.values())), stress, slip)
    seconds = round(time.monotonic() - start, 1)
    tell(counts | {"solver": options.solver} | report | {"seconds": seconds}, arguments.report)


def computed_solution(model: ElasticModel, options: SolveOptions, folder: Path) -> tuple[Solution, dict]:
    """Return what CalculiX or Abaqus finds for the model's deck, which it runs in `folder`, and a report.

    Raises CraftmeshError as `run_deck`, and for results that cannot be read.
    """
    results = run_deck(model, options, folder)
    read = read_displacements if options.solver == CALCULIX else read_displacement_table
    return _of_table(model, read(results), options.solver, results)


def given_solution(model: ElasticModel, path: Path) -> tuple[Solution, dict]:
    """Read the field that the user brings; raises CraftmeshError that says what is waited for."""
    if not path.exists():
        count = len(model.mesh.points)
        raise CraftmeshError(
            f"solver external: waits for {path}: {FORM}, a row for each node 1 to {count} of the deck that "
            "`craftmesh inp` writes with the same options; put it there and start again"
        )
    return _of_table(model, read_displacement_table(path), EXTERNAL, path)


def _of_table(
    model: ElasticModel, rows: tuple[np.ndarray, np.ndarray], solver: str, path: Path
) -> tuple[Solution, dict]:
    """Return the solution of the deck's nodes by number (k,), which move by (k, 3) in its unit."""
    numbers, displacement = rows
    return foreign_solution(model, numbers, displacement / model.scale, solver, str(path))


@contextmanager
def _folder(options: SolveOptions, arguments: argparse.Namespace) -> Iterator[Path]:
    """Yield the folder of a program, which is removed where it went well, unless --work names it."""
    output: Path = arguments.output
    folder = arguments.work or output.with_name(f"{output.stem}_{options.solver}")
    yield folder
    if not arguments.work:
        shutil.rmtree(folder)


def _built_in(
    solver: Callable[..., tuple[Any, dict]], model: ElasticModel, options: SolveOptions
) -> tuple[Any, dict]:
    print(f"{model.mesh.points.size} unknowns, about {memory_of(model.mesh):.1f} GB", flush=True)
    with ProgressLine("solve") as progress:
        return solver(model, options, progress)


def _solution(
    model: ElasticModel, options: SolveOptions, arguments: argparse.Namespace, case: str = ""
) -> tuple[Solution, dict]:
    """Return the solution of a model's load, and a report; case: its name among several."""
    if options.solver == BUILTIN:
        return _built_in(solve, model, options)
    if options.solver == EXTERNAL:
        given: Path = arguments.field or arguments.output.with_name(FIELD)
        return given_solution(model, *waited_for(given, [case] if case else []))
    with _folder(options, arguments) as folder:
        return computed_solution(model, options, folder / case)


def _combinations(
    model: ElasticModel, options: SolveOptions, arguments: argparse.Namespace
) -> tuple[dict[str, Solution], dict]:
    """Return the solutions of a model's combinations by name; other programs solve the load cases."""
    if options.solver == BUILTIN:
        return _built_in(solve_combinations, model, options)
    fields = {
        case: _solution(replace(model, load=load, cases={}), options, arguments, case)[0].displacement
        for case, load in model.cases.items()
    }
    numbers = np.arange(1, len(model.mesh.points) + 1)
    solutions, figures = {}, {}
    for one in model.combinations:
        solutions[one.name], figures[one.name] = foreign_solution(
            model.under(one), numbers, one.sum_of(fields), options.solver, one.name
        )
    return solutions, {"load_cases": figures}


def _write_vtu(
    path: Path,
    model: ElasticModel,
    solution: Solution,
    stress: np.ndarray | None,
    slip: np.ndarray | None,
) -> None:
    """Write the fields; stress (n, 6), slip (n, s): of nodes where they are known, else by elasticity."""
    found = grain_stress(model, solution.displacement)
    node, mesh = found.node, model.mesh
    moved, values = solution.displacement[node], found.stress if stress is None else stress[node]
    slipped = None if slip is None else slip[node].sum(axis=1)
    write_solution_vtu(path, mesh.points[node], found.tets, mesh.grain, node + 1, moved, values, slipped)


def _write_slip(
    path: Path, points: np.ndarray, slip: np.ndarray | None, materials: UserMaterials | None
) -> None:
    """Write the slip (n, s) of systems at nodes, summed on each plane, as `read_slip_table` reads it."""
    of = [one.slip_planes for one in materials.by_phase.values()] if materials else []
    planes = next((names for names in of if slip is not None and len(names) == slip.shape[1]), ())
    if slip is None or not planes:
        raise CraftmeshError(
            "--slip-table: the user material does not say which state variables are slip of which planes; "
            "give its template slip and slip_planes, as many"
        )
    columns = {f"slip_{plane}": np.zeros(len(points)) for plane in planes}
    for plane, own in zip(planes, slip.T):
        columns[f"slip_{plane}"] += own
    write_front(path, {"points": points} | columns)
