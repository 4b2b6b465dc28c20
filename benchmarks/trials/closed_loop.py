"""The closed loop on a random crack: meshed, checked, solved, K found, grown, and again."""

import contextlib
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from craftmesh.cli import main
from craftmesh.growth.extension import UNSTABLE
from craftmesh.growth.grow_crack import LEFT, STANDS
from craftmesh.growth.trust import DOUBTED
from craftmesh.io.front_csv import front_columns, write_front
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import read_crack
from craftmesh.mesh.front_frames import front_frames
from craftmesh.surface.measure import area_vectors
from craftmesh.types import Crack
from trials.chain import run_chain
from trials.drawing import Drawn
from trials.kinds import MATERIALS
from trials.one_seed import checked, judge
from trials.sheets import Sheet
from trials.verdict import faults_of

STREAM = 77  # of the random numbers that say how far a seed's crack goes
STEPS_IN_L_MIN = (1.5, 2.0, 3.0)  # by how much it grows at each increment
KEPT = (
    "renewed",
    "tets",
    "flat",
    "ar_under_5_pct",
    "poor_pct",
    "dihedral_min",
    "front_node",
    "facet",
    "faults",
)
# Ends that are the crack's own, by their first words; any other end is a fault of the program.
PHYSICS = {
    "the crack parts the body": "severed",
    "the crack severs the body": "severed",
    LEFT: "left the body",
    STANDS: "arrested",
    f"the crack is {UNSTABLE}": "unstable",
}
DONE = "all increments done"


def kind_of_end(ended: str) -> str:
    """Return the kind of an end, `NNN: reason`, in a few words; a fault keeps the stage's name."""
    reason = ended.partition(": ")[2]
    known = (kind for start, kind in PHYSICS.items() if reason.startswith(start))
    return DONE if not ended else next(known, f"fault: {reason.partition(':')[0]}")


class Stopped(Exception):
    """A verb of the loop that refused, and what it said."""


def closed_loop(
    case: Drawn, folder: Path, increments: int, judged: bool, correct: bool = True, reuse: bool = False
) -> dict:
    """Return a row for each increment that became a deck, and why the growth ended before its time.

    The body is pulled along the axis nearest to the first crack's normal, K found with quarter points.
    correct: lay each strip again, turned by the kinks at its end, as campaigns do. reuse: renew the mesh of
    the increment before.
    """
    write_labels(folder / "labels.npz", case.voxels)
    extension = _extension(case)
    found: dict = {"extension": extension, "rows": [], "ended": "", "faults": {}}
    crack, load, made = None, "", None
    material = MATERIALS.get(case.kinds["volume"].split()[0], MATERIALS["isotropic"])
    for increment in range(increments):
        own = folder / f"{increment:03d}"
        own.mkdir()
        made = run_chain(case, own, crack=crack, before=made if reuse else None)
        row = checked(case, made) | {"renewed": made.renewed}
        if made.deck is not None and judged:
            row |= judge(made.deck)
        row["faults"] = faults_of(row)
        found["faults"] |= {f"{increment:03d} {k}": v for k, v in row["faults"].items()}
        if made.mesh is None:
            found["ended"] = f"{increment:03d}: {made.stage}: {made.refusal}"
            break
        found["rows"].append({key: row[key] for key in KEPT if key in row})
        row = found["rows"][-1]
        crack = read_crack(own / "crack.vtp")
        if not crack.fronts:
            found["ended"] = f"{increment:03d}: the crack parts the body"
            break
        load = load or f"--load stress --magnitude 1 --quarter-points --axis {_axis(crack)}"
        write_front(own / "front.csv", front_frames(made.mesh).columns())
        steps = _steps(folder, increment) if correct else ""
        try:
            grown, report = _grown(folder, own, f"{load} --material {material}", extension, steps)
        except Stopped as stopped:
            found["ended"] = f"{increment:03d}: {stopped}"
            found["faults"][f"{increment:03d} growth"] = str(stopped)
            break
        row |= _trust(own / "sif.csv")
        if report["ended"]:
            found["ended"] = f"{increment:03d}: {report['ended']}"
            break
        row |= {"repairs": report.get("repairs", {})}
        crack, case = grown, _as_given(case, grown)
    return found | {"end": kind_of_end(found["ended"])}


def _extension(case: Drawn) -> float:
    rng = np.random.default_rng([case.seed, STREAM])
    return float(rng.choice(STEPS_IN_L_MIN)) * float(case.sizes.l_min or 0)


def _axis(crack: Crack) -> str:
    """Return the axis nearest to the crack's mean normal."""
    return "xyz"[int(np.abs(area_vectors(crack.points, crack.triangles).sum(axis=0)).argmax())]


def _steps(folder: Path, increment: int) -> str:
    """Return the flags of `grow` for the step of an increment and, but for the first, that before it."""
    flags = f"--base {folder}/{increment:03d}/base.vtp --step {folder}/{increment:03d}/step.csv"
    before = folder / f"{increment - 1:03d}"
    return flags + (f" --last-base {before}/base.vtp --last-step {before}/step.csv" if increment else "")


def _grown(folder: Path, own: Path, model: str, extension: float, steps: str) -> tuple[Crack, dict]:
    """Return the crack grown by its own K, and the report of its growth."""
    labels = folder / "labels.npz"
    known = f"--microstructure {labels} {model}"
    _verb(f"solve {own}/volume.vtu {known} -o {own}/solution.npz")
    _verb(
        f"fracture {own}/volume.vtu {own}/solution.npz {known} --crack {own}/crack.vtp "
        f"--extension {extension!r} -o {own}/sif.csv"
    )
    _verb(
        f"grow {own}/crack.vtp {own}/sif.csv {own}/front.csv --volume {labels} "
        f"-o {own}/grown.vtp --report {own}/growth.json {steps}"
    )
    return read_crack(own / "grown.vtp"), json.loads((own / "growth.json").read_text())


def _trust(path: Path) -> dict[str, int]:
    """Return the number of nodes inside the body, and of those whose K is trusted."""
    found = front_columns(path, (), "made by `craftmesh fracture`", words=("flags",))
    flags = [set(str(word).split("+")) for word in found["flags"]]
    inside = [words for words in flags if "end" not in words]
    return {"nodes": len(inside), "trusted": sum(words.isdisjoint(DOUBTED) for words in inside)}


def _verb(line: str) -> None:
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        status = main(line.split())
    if status:
        last = said.getvalue().strip().splitlines()[-1:]
        raise Stopped(f"{line.split()[0]}: {' '.join(last)}")


def _as_given(case: Drawn, crack: Crack) -> Drawn:
    """Return the case whose given sheet is that crack."""
    fronts = tuple(crack.points[front] for front in crack.fronts)
    sheet = Sheet(crack.points, crack.triangles, fronts, flat=False)
    return replace(case, sheet=sheet, prescribed=None, with_front=True, parts=())
