"""The built-in solver on the decks of the cases: cost, iterations, residual; CalculiX beside it."""

import shutil
import subprocess
import tempfile

import numpy as np
from cases import AL6XN, AL1050, COPPER, G26, TINY, Case, Start, generated
from deck import box_mesh
from measure import flags, in_child, load, print_table, repeated, save, timed, write_json

# 5.9 million unknowns
BOX = Case(box_mesh, (1_390_000,))
# small enough for CalculiX
SMALL = Case(generated, (12, 4))
CASES = {
    "small": SMALL,
    "tiny": TINY,
    "g26": G26,
    "al6xn": AL6XN,
    "al1050": AL1050,
    "copper": COPPER,
    "box": BOX,
}
DEFAULT = ("small", "tiny", "g26", "al6xn", "al1050")
# CalculiX takes minutes and gigabytes beyond.
PEER_UNKNOWNS = 200_000
MATERIAL = "cubic:168400,121400,75400"  # copper; Zener's ratio is 3.2
METHODS = {
    "builtin": {},
    "builtin, quarter points": {"quarter_points": True},
    "calculix": {"solver": "calculix"},
}
COLUMNS = {
    "case": "case",
    "method": "method",
    "elements": "elements",
    "unknowns": "unknowns",
    "iterations": "iterations",
    "residual": "residual",
    "off": "off builtin",
    "cpu_s": "CPU s",
    "model_s": "of it read and model",
    "peak_mb": "peak MB",
    "memory_gb": "said GB",
}


def prepare(case: Case, path: str) -> int:
    """Write the case's mesh, its grains turned at random; return the number of elements."""
    from craftmesh.assembly.assemble import assemble
    from craftmesh.gradation.gradate import gradate
    from craftmesh.mechanics.orientation import random_orientations
    from craftmesh.tetrahedra.options import TetrahedralizeOptions
    from craftmesh.tetrahedra.tetrahedralize import tetrahedralize

    mesh = case.start()
    if isinstance(mesh, Start):
        surface, _ = gradate(mesh.surface, mesh.sizing)
        grains, _ = tetrahedralize(surface, mesh.sizing, TetrahedralizeOptions(), mesh.islands)
        mesh, _ = assemble(surface, grains)
    turned = random_orientations(int(mesh.grain.max()) + 1, np.random.default_rng(3))
    sets = {name: np.array(ids) for name, ids in mesh.node_sets.items()}
    faces = {name: np.array(rows) for name, rows in mesh.face_sets.items()}
    save(path, (mesh.points, mesh.tets, mesh.grain, sets, faces, turned))
    return len(mesh.tets)


def model_of(path: str, changes: dict):
    """Read a prepared case and make its model."""
    from craftmesh.mechanics.model import elastic_model
    from craftmesh.mechanics.model_options import ModelOptions
    from craftmesh.types import TetMesh

    *parts, turned = load(path)
    return elastic_model(TetMesh(*parts), ModelOptions(material=(MATERIAL,), **changes), turned)[0]


def run_solver(path: str, changes: dict) -> dict:
    """Solve a prepared case; the cost is that of reading, model and solver together."""
    changes = dict(changes)
    solver = changes.pop("solver", "builtin")
    model, first = timed(model_of, path, changes)
    report, second = timed(SOLVERS[solver], model, f"{path}.{solver}.npy")
    cost = {"cpu_s": first["cpu_s"] + second["cpu_s"], "peak_mb": second["peak_mb"]}
    return cost | {"model_s": first["cpu_s"], "elements": len(model.mesh.tets)} | report


def builtin(model, target: str) -> dict:
    from craftmesh.solve.solve import solve

    solution, report = solve(model)
    np.save(target, solution.displacement)
    return report


def calculix(model, target: str) -> dict:
    """Solve by CalculiX and compare with what the built-in solver found last."""
    from craftmesh.deck.write_deck import write_model
    from craftmesh.io.model_tables import read_displacements
    from craftmesh.solve.foreign import foreign_solution

    with tempfile.TemporaryDirectory() as folder:
        write_model(f"{folder}/model.inp", model)
        subprocess.run(["ccx", "-i", "model"], cwd=folder, check=True, capture_output=True)
        numbers, moved = read_displacements(f"{folder}/model.frd")
    solution, report = foreign_solution(model, numbers, moved, "calculix", "model.frd")
    own = np.load(target.replace("calculix", "builtin"))
    return report | {"off": float(np.abs(own - solution.displacement).max() / np.abs(own).max())}


SOLVERS = {"builtin": builtin, "calculix": calculix}


def methods_of(elements: int, peers: bool) -> dict:
    # some 1.4 nodes an element
    small = 3 * 1.4 * elements < PEER_UNKNOWNS
    order = ("builtin, quarter points", "builtin", "calculix")
    chosen = order if peers and small and shutil.which("ccx") else order[:2]
    return {name: METHODS[name] for name in chosen}


def main() -> None:
    arguments = flags(__doc__, list(CASES)).parse_args()
    rows: list[dict] = []
    in_child(run_tiny)  # compiles the kernels
    for name in arguments.case or DEFAULT:
        case = CASES[name]
        if case.missing:
            print(f"{name}: skipped, {case.missing}")
            continue
        with tempfile.TemporaryDirectory() as folder:
            path = f"{folder}/mesh"
            elements = in_child(prepare, case, path)
            for method, changes in methods_of(elements, not arguments.no_peers).items():
                figures = repeated(arguments.runs, run_solver, path, changes)
                rows.append({"case": name, "method": method} | figures)
                write_json(arguments.json, {"rows": rows})
    print_table(rows, COLUMNS)


def run_tiny() -> None:
    with tempfile.TemporaryDirectory() as folder:
        prepare(TINY, f"{folder}/mesh")
        run_solver(f"{folder}/mesh", {})


if __name__ == "__main__":
    main()
