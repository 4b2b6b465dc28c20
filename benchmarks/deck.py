"""Writing a large C3D10 model: the deck, from the library and as a command, and the other formats."""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from measure import in_child, print_table, repeated, timed, write_json

COLUMNS = {
    "case": "case",
    "method": "method",
    "elements": "elements",
    "cpu_s": "CPU s",
    "wall_s": "wall s",
    "peak_mb": "peak MB",
    "file_mb": "file MB",
}
GRAINS_PER_EDGE = 6
# The six tetrahedra of a cube along its diagonal; neighbouring cubes match face by face.
_KUHN = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]


def box_mesh(elements: int):
    """Return a 4-node TetMesh of a cracked box with 216 grains and at least `elements` elements.

    The spacing is irrational, so that coordinates take all their digits, as those of real meshes do.
    """
    from craftmesh.mesh.front import front_polylines
    from craftmesh.mesh.mesh_sets import node_sets_of
    from craftmesh.types import TetMesh

    n = max(GRAINS_PER_EDGE, int(np.ceil((elements / 6) ** (1 / 3) - 1e-9)))
    cells = np.indices((n, n, n)).reshape(3, -1).T
    corner = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    strides = np.array([(n + 1) ** 2, n + 1, 1])
    tets = ((cells @ strides)[:, None] + corner @ strides)[:, _KUHN].reshape(-1, 4)
    grain = 1 + cells * GRAINS_PER_EDGE // n @ GRAINS_PER_EDGE ** np.arange(3)
    nodes = np.indices((n + 1,) * 3).reshape(3, -1).T
    above = np.repeat(cells[:, 2] >= n // 2, 6)
    nodes = _open_crack(nodes, tets, above, n)
    faces = _face_sets(nodes, tets, above, n)
    points = nodes / np.sqrt(2)
    return TetMesh(
        points,
        tets,
        np.repeat(grain, 6),
        node_sets_of(tets, faces, front_polylines(points, tets, faces)),
        faces,
    )


def _in_crack(nodes, n: int) -> np.ndarray:
    """Return what lies inside a hexagon along the grid's diagonals in the box's middle plane."""
    x, y = nodes[..., 0] - n / 2, nodes[..., 1] - n / 2
    inside = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(x - y)) < n // 4
    return inside & (nodes[..., 2] == n // 2)


def _open_crack(nodes, tets, above, n: int) -> np.ndarray:
    """Give the tets above the crack nodes of their own, in place; return all nodes."""
    own = np.flatnonzero(_in_crack(nodes, n))
    new = np.arange(len(nodes))
    new[own] = len(nodes) + np.arange(len(own))
    tets[above] = new[tets[above]]
    return np.concatenate([nodes, nodes[own]])


def _face_sets(nodes, tets, above, n: int) -> dict[str, np.ndarray]:
    from craftmesh.mesh.tet_connectivity import half_faces
    from craftmesh.types import BOX_PLANES

    halves = half_faces(tets)
    rows = {
        name: (nodes[:, plane // 2] == (0, n)[plane % 2])[halves].all(axis=1)
        for plane, name in enumerate(BOX_PLANES)
    }
    in_plane = np.flatnonzero((nodes[:, 2] == n // 2)[halves].all(axis=1))
    lips = in_plane[_in_crack(nodes[halves[in_plane]].mean(axis=1), n)]
    chosen = {name: np.flatnonzero(on) for name, on in rows.items()}
    chosen |= {"CRACK_LIP_A": lips[above[lips // 4]], "CRACK_LIP_B": lips[~above[lips // 4]]}
    return {name: np.stack([faces // 4, faces % 4], axis=1) for name, faces in chosen.items()}


def prepare(elements: int, path: str) -> None:
    from craftmesh.io.vtk import write_tets

    write_tets(path, box_mesh(elements))


def run_library(path: str, name: str, changes: dict) -> dict:
    """Measure `write_deck` alone; the peak holds the mesh, read before."""
    from craftmesh.deck.write_deck import DeckOptions, write_deck
    from craftmesh.io.vtk import read_tets

    mesh = read_tets(path)
    return measured(path, name, lambda target: write_deck(target, mesh, DeckOptions(**changes)))


def run_command(path: str, name: str, _: dict) -> dict:
    """Measure a whole command, from reading the mesh on."""
    from craftmesh.cli import run

    verb = "inp" if name.endswith(".inp") else "export"
    return measured(path, name, lambda target: run([verb, path, "-o", target]))


def measured(path: str, name: str, write) -> dict:
    """Return cost and size of the files that `write`, a function of the path, makes."""
    with tempfile.TemporaryDirectory(dir=Path(path).parent) as folder:
        start = time.perf_counter()
        _, cost = timed(write, f"{folder}/{name}")
        wall = time.perf_counter() - start
        size = sum(file.stat().st_size for file in Path(folder).iterdir())
    return cost | {"wall_s": wall, "file_mb": size / 1e6}


METHODS = {
    "write_deck": (run_library, "model.inp", {}),
    "write_deck, includes": (run_library, "model.inp", {"includes": True}),
    "write_deck, quarter points": (run_library, "model.inp", {"quarter_points": True}),
    "craftmesh inp": (run_command, "model.inp", {}),
    "craftmesh export .vtu": (run_command, "model.vtu", {}),
    "craftmesh export .msh": (run_command, "model.msh", {}),
    "craftmesh export .e": (run_command, "model.e", {}),
}


def parser() -> argparse.ArgumentParser:
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument(
        "--elements",
        type=int,
        default=5_000_000,
        metavar="N",
        help="least number of elements (default 5e6)",
    )
    flags.add_argument(
        "--method", action="append", choices=METHODS, help="only this one; may be given several times"
    )
    flags.add_argument("--runs", type=int, default=3, metavar="N", help="runs per figure (default 3)")
    flags.add_argument("--json", type=Path, metavar="FILE", help="write all figures to this file")
    return flags


def main() -> None:
    arguments = parser().parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        in_child(prepare, 1, f"{folder}/warm-up.vtu")
        in_child(run_library, f"{folder}/warm-up.vtu", "model.inp", {"quarter_points": True})
        in_child(prepare, arguments.elements, f"{folder}/box.vtu")
        count = in_child(elements_of, f"{folder}/box.vtu")
        for method in arguments.method or METHODS:
            print(f"{count} elements, {method} ...", file=sys.stderr)
            function, name, changes = METHODS[method]
            figures = repeated(arguments.runs, function, f"{folder}/box.vtu", name, changes)
            rows.append({"case": "box", "method": method, "elements": count} | figures)
            write_json(arguments.json, {"rows": rows})
    print_table(rows, COLUMNS)


def elements_of(path: str) -> int:
    from craftmesh.io.vtk import read_tets

    return len(read_tets(path).tets)


if __name__ == "__main__":
    main()
