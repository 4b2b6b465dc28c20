"""Find the displacements of the deck's model: by the built-in solver, CalculiX, Abaqus or from a file."""

import argparse
import os
import shutil
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import (
    add_microstructure,
    known_of_files,
    user_materials,
    with_element_axes,
)
from craftmesh.commands.run_deck import FIELD, JOB, Ended, run_deck, solved_history
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell, warn
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_model
from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import write_front
from craftmesh.io.model_tables import FORM, read_displacement_table, read_displacements
from craftmesh.io.stage_npz import write_solution, write_solution_vtu, write_solutions
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.user_materials import UserMaterials
from craftmesh.progress import ProgressLine
from craftmesh.solve.options import BUILTIN, CALCULIX, EXTERNAL, SolveOptions
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
    add_options(parser, DeckOptions, SolveOptions, skip=("includes",))


def run(arguments: argparse.Namespace) -> None:
    options, deck = options_from(arguments, SolveOptions), options_from(arguments, DeckOptions)
    if deck.cohesive and options.solver != BUILTIN:
        raise CraftmeshError(
            f"solver {options.solver}: has no cohesive layers; run the deck of `craftmesh inp`, in Abaqus"
        )
    if deck.cohesive:
        warn("cohesive layers are in the deck alone; this field, and K by it, are those of the welded body")
    known = known_of_files(arguments)
    mesh = read_tets(arguments.volume)
    model, counts = elastic_model(mesh, deck, **known)
    start = time.monotonic()
    stress = slip = None
    if deck.history and options.solver != BUILTIN:
        materials = user_materials(deck.user_material, known)
        model = with_element_axes(model, deck, arguments, materials)
        (solution, stress, slip), report = _ended(model, options, deck, materials, arguments)
        write_solution(arguments.output, solution)
        if arguments.slip_table:
            _write_slip(arguments.slip_table, model.mesh.points, slip, materials)
    elif model.combinations:
        solutions, report = _combinations(model, options, arguments)
        write_solutions(arguments.output, solutions)
        solution = next(iter(solutions.values()))
    else:
        solution, report = _solution(model, options, arguments)
        write_solution(arguments.output, solution)
    if arguments.vtu:
        _write_vtu(arguments.vtu, model, solution, stress, slip)
    seconds = round(time.monotonic() - start, 1)
    tell(counts | {"solver": options.solver} | report | {"seconds": seconds}, arguments.report)


@dataclass(frozen=True, eq=False)
class ForeignField:
    """Numbers (k,) of the deck's nodes, their displacements (k, 3) in the model's unit, and their file."""

    numbers: np.ndarray
    displacement: np.ndarray
    source: str


def computed_field(model: ElasticModel, options: SolveOptions, folder: Path) -> ForeignField:
    """Write the deck into `folder`, run the solver on it there, and read the field.

    Raises CraftmeshError for a deck that CalculiX would refuse, for a program that fails, and for results
    that cannot be read.
    """
    folder.mkdir(parents=True, exist_ok=True)
    results = folder / (f"{JOB}.frd" if options.solver == CALCULIX else FIELD)
    write_model(folder / f"{JOB}.inp", model)
    run_deck(model, options, results)
    read = read_displacements if options.solver == CALCULIX else read_displacement_table
    return _in_model_unit(model, *read(results), str(results))


def _in_model_unit(
    model: ElasticModel, numbers: np.ndarray, displacement: np.ndarray, source: str
) -> ForeignField:
    return ForeignField(numbers, displacement / model.scale, source)


def given_field(model: ElasticModel, path: str | os.PathLike) -> ForeignField:
    """Read the field that the user brings; raises CraftmeshError that says what is waited for."""
    if not Path(path).exists():
        count = len(model.mesh.points)
        raise CraftmeshError(
            f"solver external: waits for {path}: {FORM}, a row for each node 1 to {count} of the deck that "
            "`craftmesh inp` writes with the same options; put it there and start again"
        )
    return _in_model_unit(model, *read_displacement_table(path), str(path))


def _ended(
    model: ElasticModel,
    options: SolveOptions,
    deck: DeckOptions,
    materials: UserMaterials | None,
    arguments: argparse.Namespace,
) -> tuple[Ended, dict]:
    """Return the end of a load in steps, and a report."""
    if options.solver != CALCULIX:
        raise CraftmeshError(
            f"solver {options.solver}: reads linear elastic fields alone, and the load comes in steps "
            "(steps, user_material, lip_contact); expected calculix, or run the deck of `craftmesh inp`"
        )
    folder = arguments.work or _folder(arguments.output, options)
    result = solved_history(model, options, deck, materials, folder)
    if not arguments.work:
        shutil.rmtree(folder)
    return result


def _folder(output: Path, options: SolveOptions) -> Path:
    return output.with_name(f"{output.stem}_{options.solver}")


def _solution(
    model: ElasticModel, options: SolveOptions, arguments: argparse.Namespace, case: str = ""
) -> tuple[Solution, dict]:
    """Return the solution of a model's load, and a report; case: its name among several."""
    output: Path = arguments.output
    if options.solver == BUILTIN:
        print(f"{model.mesh.points.size} unknowns, about {memory_of(model.mesh):.1f} GB", flush=True)
        with ProgressLine("solve") as progress:
            return solve(model, options, progress)
    if options.solver == EXTERNAL:
        given: Path = arguments.field or output.with_name(FIELD)
        found = given_field(model, given.with_stem(f"{given.stem}_{case}") if case else given)
        return foreign_solution(model, found.numbers, found.displacement, EXTERNAL, found.source)
    folder = arguments.work or _folder(output, options)
    found = computed_field(model, options, folder / case)
    result = foreign_solution(model, found.numbers, found.displacement, options.solver, found.source)
    if not arguments.work:
        shutil.rmtree(folder)
    return result


def _combinations(
    model: ElasticModel, options: SolveOptions, arguments: argparse.Namespace
) -> tuple[dict[str, Solution], dict]:
    """Return the solutions of a model's combinations by name; other programs solve the load cases."""
    if options.solver == BUILTIN:
        print(f"{model.mesh.points.size} unknowns, about {memory_of(model.mesh):.1f} GB", flush=True)
        with ProgressLine("solve") as progress:
            return solve_combinations(model, options, progress)
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
