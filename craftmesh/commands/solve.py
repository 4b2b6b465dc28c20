"""Find the displacements of the deck's model: by the built-in solver, CalculiX, Abaqus or from a file."""

import argparse
import os
import shutil
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_microstructure, known_of_files
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell
from craftmesh.deck.limits import deck_warning
from craftmesh.deck.write_deck import write_model
from craftmesh.errors import CraftmeshError
from craftmesh.io.model_tables import FORM, read_displacement_table, read_displacements
from craftmesh.io.stage_npz import write_solution, write_solution_vtu, write_solutions
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.processes import job
from craftmesh.processes.job import run_program
from craftmesh.progress import ProgressLine
from craftmesh.solve.options import ABAQUS, BUILTIN, CALCULIX, EXTERNAL, SolveOptions, words_of
from craftmesh.solve.problem import foreign_solution
from craftmesh.solve.solve import memory_of, solve, solve_combinations
from craftmesh.solve.stress import grain_stress
from craftmesh.types import Solution

JOB, FIELD = "model", "field.csv"
_CALLS = {
    CALCULIX: ("ccx -i {job}",),
    ABAQUS: (
        "abaqus job={job} input={job}.inp interactive ask_delete=OFF output_precision=full",
        "abaqus python {script} {job}.odb {field}",
    ),
}
# CalculiX where it was built without a direct solver; the field would be wrong without a word.
_ITERATIVE = "iterative solver"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    add_output(parser, "solution .npz: displacements and reactions by the deck's nodes")
    add_file(parser, "--vtu", "write displacements and stresses for ParaView")
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
        found = grain_stress(model, solution.displacement)
        node, moved = found.node, solution.displacement[found.node]
        place = model.mesh.points[node], found.tets, model.mesh.grain, node + 1
        write_solution_vtu(arguments.vtu, *place, moved, found.stress)
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
    warning = deck_warning(model) if options.solver == CALCULIX else ""
    if warning:
        raise CraftmeshError(f"calculix: {warning}")
    folder.mkdir(parents=True, exist_ok=True)
    results = folder / (f"{JOB}.frd" if options.solver == CALCULIX else FIELD)
    results.unlink(missing_ok=True)
    write_model(folder / f"{JOB}.inp", model)
    script = Path(job.__file__).with_name("abaqus_displacements.py")
    limits = job.Limits(options.time_limit, options.memory_limit)
    for number, call in enumerate(options.command or _CALLS[options.solver], 1):
        log = folder.resolve() / f"{options.solver}_{number}.log"
        said = run_program(words_of(call, JOB, str(script), FIELD), folder.resolve(), limits, log)
        if options.solver == CALCULIX and _ITERATIVE in said:
            raise CraftmeshError(
                f"calculix: took its {_ITERATIVE}, which is not exact; take a ccx with SPOOLES"
            )
    if not results.exists():
        raise CraftmeshError(f"{options.solver}: left no {results.name}; see the files in {folder}")
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
