"""Fields from other programs: CalculiX and Abaqus run on the deck, or a file that the user brings."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from craftmesh.deck.limits import deck_warning
from craftmesh.deck.write_deck import write_model
from craftmesh.errors import CraftmeshError
from craftmesh.io.model_tables import FORM, read_displacement_table, read_displacements
from craftmesh.mechanics.model import ElasticModel
from craftmesh.processes import job
from craftmesh.processes.program import run_program
from craftmesh.solve.options import ABAQUS, CALCULIX, SolveOptions, words_of

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
