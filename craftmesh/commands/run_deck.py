"""Run external solvers on an input deck; read the final fields and the face histories of a load history."""

from pathlib import Path

import numpy as np

from craftmesh.deck.limits import deck_warning
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_model
from craftmesh.errors import CraftmeshError
from craftmesh.fracture.rings import NodalField, front_rings
from craftmesh.io.model_tables import read_face_prints, read_frd
from craftmesh.mechanics.load import acting_faces, face_loop
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.user_materials import UserMaterials
from craftmesh.processes import job
from craftmesh.processes.job import run_program
from craftmesh.solve.foreign import in_order
from craftmesh.solve.options import ABAQUS, CALCULIX, FIELD, SolveOptions, split_command
from craftmesh.types import Solution

JOB = "model"
_CALLS = {
    CALCULIX: ("ccx -i {job}",),
    ABAQUS: (
        "abaqus job={job} input={job}.inp interactive ask_delete=OFF output_precision=full",
        "abaqus python {script} {job}.odb {field}",
    ),
}
# CalculiX without a direct solver prints this; its field would be wrong without a warning.
_ITERATIVE = "iterative solver"

_FIELDS = {"DISP": 3, "FORC": 3, "STRESS": 6}
# Components of a .frd file, xx, yy, zz, xy, yz, zx, in the order 11, 22, 33, 12, 13, 23.
_ORDER = [0, 1, 2, 3, 5, 4]


def run_deck(
    model: ElasticModel,
    options: SolveOptions,
    folder: Path,
    deck: DeckOptions | None = None,
    materials: UserMaterials | None = None,
) -> Path:
    """Write the deck into `folder`, run the solver there, and return the path of its results file.

    deck, materials: options and user materials of a load history; the deck then also prints displacements
    and forces of faces. Raises CraftmeshError for a deck that CalculiX would reject, for a CalculiX without
    a direct solver, and for a program that fails or writes no results.
    """
    warning = deck_warning(model) if options.solver == CALCULIX else ""
    if warning:
        raise CraftmeshError(f"calculix: {warning}")
    folder.mkdir(parents=True, exist_ok=True)
    results = folder.resolve() / (f"{JOB}.frd" if options.solver == CALCULIX else FIELD)
    results.unlink(missing_ok=True)
    write_model(folder / f"{JOB}.inp", model, deck or DeckOptions(), materials, traced=deck is not None)
    script = Path(job.__file__).with_name("abaqus_displacements.py")
    limits = job.Limits(options.time_limit, options.memory_limit)
    for number, call in enumerate(options.command or _CALLS[options.solver], 1):
        log = results.parent / f"{options.solver}_{number}.log"
        said = run_program(split_command(call, JOB, str(script), FIELD), results.parent, limits, log)
        if options.solver == CALCULIX and _ITERATIVE in said:
            raise CraftmeshError(
                f"calculix: used its {_ITERATIVE}, which is not exact; install a ccx with SPOOLES"
            )
    if not results.exists():
        raise CraftmeshError(f"{options.solver}: wrote no {results.name}; see the files in {folder}")
    return results


def solved_history(
    model: ElasticModel,
    options: SolveOptions,
    deck: DeckOptions,
    materials: UserMaterials | None,
    folder: Path,
) -> tuple[Solution, np.ndarray, np.ndarray | None, dict]:
    """Return the solution at the end of a deck's load history, nodal stress, slip and a report.

    CalculiX runs in `folder`. Stress (n, 6): 11, 22, 33, 12, 13, 23. Slip (n, s) of the slip systems, None
    if the materials do not define it. Nodal values are CalculiX' means over elements. If each
    user material writes the energy density (ENER), elements have 10 nodes and no temperature varies, the
    report has J on rings and the opening of each front. Raises CraftmeshError if the program fails, or if
    results are missing or cannot be read.
    """
    results = run_deck(model, options, folder, deck, materials)
    users = list(materials.by_phase.values()) if materials else []
    first, last = next(filter(None, (one.slip for one in users)), (1, 0))
    # J on rings lacks the term of a temperature that varies
    has_work = all("ENER" in one.output for one in users) and model.temperature is None
    columns = _FIELDS | ({"SDV": last} if last else {}) | ({"ENER": 1} if has_work else {})
    count = len(model.mesh.points)
    read = read_frd(results, columns).items()
    fields = {name: in_order(*found, count, f"{results}: {name}") for name, found in read}
    slip = fields["SDV"][:, first - 1 :] if last else None
    record: dict[str, str | int | float] = {"solver": CALCULIX, "user_material": deck.user_material}
    history = _history(model, deck, results.with_suffix(".dat"))
    record["increments"] = len(history["time"]) - 1
    if slip is not None:
        record["largest_slip"] = float(slip.sum(axis=1).max())
    stress = fields["STRESS"][:, _ORDER]
    moved, forces = fields["DISP"] / model.scale, fields["FORC"] / model.scale**2
    if has_work and model.mesh.tets.shape[1] == 10:
        found = front_rings(model.mesh, NodalField(moved, stress, fields["ENER"][:, 0]))
        for number, front in enumerate(found, 1):
            record |= {f"front {number}: {name}": value for name, value in front.figures().items()}
    solution = Solution(moved, forces, record, None, history)
    return solution, stress, slip, {"unknowns": moved.size} | record


def _history(model: ElasticModel, deck: DeckOptions, path: Path) -> dict[str, np.ndarray]:
    """Return the load history as columns by name, one row per output time, in the model's unit.

    The columns are the time, and nominal strain and stress of each face that is moved or pulled. Row 0 is
    the unloaded body. path: CalculiX' .dat file.
    """
    loads = model.loads(step.load for step in deck.history)
    prints = read_face_prints(path)
    columns = {}
    for plane, axis in acting_faces(loads.values()):
        found = prints[plane]
        displacement, force = found.displacement / model.scale, found.force / model.scale**2
        columns["time"] = found.times
        columns |= face_loop(model.mesh, plane, axis, found.numbers - 1, displacement, force)
    return {name: np.concatenate([[0.0], values]) for name, values in columns.items()}
