"""Find the displacements of the deck's model: by the built-in solver, CalculiX, Abaqus or from a file."""

import argparse
import shutil
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.foreign_fields import FIELD, computed_field, given_field
from craftmesh.commands.microstructure import add_microstructure, known_of_files
from craftmesh.commands.stage_io import add_output, add_report, tell
from craftmesh.io.solution import write_solution, write_solution_vtu, write_solutions
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.progress import ProgressLine
from craftmesh.solve.foreign import foreign_solution
from craftmesh.solve.options import BUILTIN, EXTERNAL, SolveOptions
from craftmesh.solve.solve import memory_of, solve, solve_combinations
from craftmesh.solve.stress import grain_stress
from craftmesh.types import Solution


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, "solution .npz: displacements and reactions by the deck's nodes")
    parser.add_argument(
        "--vtu", type=Path, metavar="FILE", help="write displacements and stresses for ParaView"
    )
    add_microstructure(parser)
    parser.add_argument(
        "--field",
        type=Path,
        metavar="FILE",
        help=f"the displacements that `external` waits for (default {FIELD} beside the output)",
    )
    parser.add_argument(
        "--work",
        type=Path,
        metavar="FOLDER",
        help="where calculix and abaqus run; kept (default: beside the output, removed in the end)",
    )
    add_report(parser)
    add_options(parser, ModelOptions, SolveOptions)


def run(arguments: argparse.Namespace) -> None:
    options = options_from(arguments, SolveOptions)
    known = known_of_files(arguments)
    mesh = read_tets(arguments.volume)
    model, counts = elastic_model(mesh, options_from(arguments, ModelOptions), **known)
    start = time.monotonic()
    if model.combinations:
        solutions, report = _combinations(model, options, arguments)
        write_solutions(arguments.output, solutions)
        solution = next(iter(solutions.values()))
    else:
        solution, report = _solution(model, options, arguments)
        write_solution(arguments.output, solution)
    if arguments.vtu:
        _write_vtu(arguments.vtu, model, solution)
    seconds = round(time.monotonic() - start, 1)
    tell(counts | {"solver": options.solver} | report | {"seconds": seconds}, arguments.report)


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
    folder = arguments.work or output.with_name(f"{output.stem}_{options.solver}")
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


def _write_vtu(path: Path, model: ElasticModel, solution: Solution) -> None:
    found = grain_stress(model, solution.displacement)
    node, mesh = found.node, model.mesh
    moved = solution.displacement[node]
    write_solution_vtu(path, mesh.points[node], found.tets, mesh.grain, node + 1, moved, found.stress)
